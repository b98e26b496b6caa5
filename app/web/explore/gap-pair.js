/** The pair and the head that the second chapter shows, by the address. No DOM here. */

import { classOf, domainOf } from "../shared/frames.js";
import { OWN_MODE } from "../shared/tables.js";

const HEAD = "head:";

/** Return the first pair of an unseen domain that is predicted right at the learned p; else the first pair.
 * @param {Frames} frames */
export function firstPair(frames) {
  const { label, domain, domains, prediction, pairs, source, learned } = frames;
  const home = domains.indexOf(source);
  const from = frames.stop(Number.isFinite(learned) ? learned : 0.5) * pairs;
  return Math.max(
    0,
    label.findIndex((k, pair) => domain[pair] !== home && prediction[from + pair] === k),
  );
}

/** Return the chosen pair: of the page's own set the one in the address, of another its pinned pair; or the one to open
 * with.
 * @param {Pick<Scene, "set" | "frames" | "opening">} scene @param {Pick<State, "vis" | "tac" | "pin">} address
 * @returns {Pair} */
export function pairOf({ set, frames, opening }, { vis, tac, pin }) {
  if (!set && (vis || tac)) return { vis, tac };
  const ref = pin === null ? (opening ?? `row:${firstPair(frames.whole ?? frames)}`) : `row:${pin}`;
  return { vis: ref, tac: ref };
}

/** Return the row of the set that a pair is, also by the name of an example; -1 if it is none.
 * @param {Pick<Scene, "frames" | "facts">} scene @param {Pair} pair */
export function rowOf({ frames, facts }, { vis, tac }) {
  const [kind, name] = vis && vis === tac ? vis.split(/:(.*)/s) : [];
  if (kind === "row") return +name < frames.pairs ? +name : -1;
  if (kind !== "example" || !facts.pairs) return -1;
  const [domain, truth, stem] = name.split("/");
  const names = facts.pairs.name;
  return frames.label.findIndex(
    (_, pair) => names[pair] === stem && classOf(frames, pair) === truth && domainOf(frames, pair) === domain,
  );
}

/** Return the head in the address: its set, "" being the page's own, and its mode of p or its name.
 * @param {Pick<State, "by">} address @param {SetRow[]} sets
 * @returns {{set: string, mode: string, head: string}} */
export function headIn({ by }, sets) {
  const at = by.lastIndexOf("/");
  const named = by.slice(0, Math.max(0, at));
  const set = sets.some(({ name, shown }) => name === named && !shown) ? named : "";
  const what = by.slice(at + 1);
  return what.startsWith(HEAD)
    ? { set, mode: OWN_MODE, head: what.slice(HEAD.length) }
    : { set, mode: what || OWN_MODE, head: "" };
}

/** Return the same as a text for the address; "" for the page's own head.
 * @param {{set?: string, mode?: string, head?: string}} of */
export function headText({ set = "", mode = OWN_MODE, head = "" }) {
  const what = head ? `${HEAD}${head}` : mode === OWN_MODE && !set ? "" : mode;
  return set ? `${set}/${what}` : what;
}
