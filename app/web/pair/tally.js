/** The visitor’s own labelled pairs: counting, what can be taught from them, and the name of the taught head. */

import { ask } from "../shared/api.js";

const FEWEST = 2; // fewest pairs of a class, and fewest classes, for teaching

/** A pair is identified by its two images. */
export const keyOf = ({ vis, tac }) => `${vis ?? ""} ${tac ?? ""}`;

/** True if the two images come from different pairs: two of the set, or one and a visitor's. */
export const mixed = ({ vis, tac }) => Boolean(vis && tac) && vis !== tac && !isOwn({ vis, tac });

/** True if all images of a pair are the visitor's own.
 * @param {Pair} pair */
export const isOwn = ({ vis, tac }) => {
  const there = [vis, tac].flatMap((ref) => ref || []);
  return there.length > 0 && there.every((ref) => ref.startsWith("image:"));
};

/** Add a pair, or replace its label. said: reading -> predicted class. */
export function withPair(pairs, pair) {
  return [...pairs.filter((one) => keyOf(one) !== keyOf(pair)), pair];
}

export const withoutPair = (pairs, key) => pairs.filter((one) => keyOf(one) !== key);

/** Correct pairs of each reading, among those that have it. */
export function tally(pairs) {
  const found = {};
  for (const { label, said } of pairs) {
    for (const [reading, answer] of Object.entries(said)) {
      found[reading] ??= { right: 0, of: 0 };
      found[reading].of += 1;
      found[reading].right += answer === label;
    }
  }
  return found;
}

/** What is missing before a head can be taught; "" if nothing. */
export function missing(pairs) {
  const counts = new Map();
  for (const { label } of pairs) counts.set(label, (counts.get(label) ?? 0) + 1);
  const enough = [...counts.values()].filter((count) => count >= FEWEST).length;
  if (enough >= FEWEST) return "";
  const there = [...counts].map(([label, count]) => `${label} ${count}`).join(", ") || "none yet";
  return `Label two pairs of each of two classes to teach it. So far: ${there}.`;
}

/** The lessons of a request; a pair is never predicted from its own label. */
export const lessonsFor = (pairs, now) =>
  pairs.filter((one) => keyOf(one) !== keyOf(now)).map(({ vis, tac, label }) => ({ vis, tac, label }));

let last = { lessons: "", taught: "" };

/** "" without lessons; `fresh` to teach again if the server may have dropped the head.
 * @param {{lessons?: Lesson[]}} own */
export async function taughtBy({ lessons }, fresh = true) {
  if (!lessons) return "";
  const key = JSON.stringify(lessons);
  if (fresh || last.lessons !== key) last = { lessons: key, taught: (await ask("taught", { lessons })).taught };
  return last.taught;
}
