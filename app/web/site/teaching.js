/** Teaching from a visitor's labelled pairs, by the rules of the library. No DOM here. */

import { IMAGES, READINGS } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { STANDING } from "./models.js";
import { PAIR } from "./rules.js";
import { rounded, stacked } from "./tensors.js";

/** The labelled pairs of a question, as the server takes them.
 * @param {{ lessons: { label: string, vis?: Ref, tac?: Ref }[] }} question */
export function lessonsIn({ lessons }) {
  const all = lessons.map((one) => ({ ...one, label: one.label.trim() }));
  if (all.length > PAIR.MOST_LESSONS)
    throw new Refusal(`${all.length} pairs are labelled, and at most ${PAIR.MOST_LESSONS} are taught here.`);
  const wrong = all.find(({ label }) => !label || label.length > PAIR.LONGEST_LABEL);
  if (wrong) throw new Refusal(`A label is '${wrong.label}'; give a name of 1 to ${PAIR.LONGEST_LABEL} letters.`);
  return all;
}

/** Teach lessons: the taught head, and the report, what is said of each lesson before and after teaching by the others.
 * @param {import("./models.js").Models} models @param {SiteHead} head @param {{ label: string, pair: Rows }[]} lessons */
export async function teach(models, head, lessons) {
  const names = lessons.map(({ label }) => label);
  const classes = [...new Set([...head.classes, ...names])];
  const pairs = lessons.map(({ pair }) => pair);
  const wanted = [...READINGS.map((name) => `p_${name}`), ...STANDING];
  const out = await models.run(head, pairs, [null], wanted);
  const there = stacked(pairs.map((pair) => IMAGES.map((name) => Number(Boolean(pair[name])))));
  const targets = stacked(names.map((name) => classes.map((other) => Number(other === name))));
  const taught = await models.rule("lessons", ...wanted.map((name) => out[name]), there, targets);
  const [share, before, after] = taught.splice(3).map(({ values }) => Array.from(values, Number));
  const judged = names.map((label, i) => ({ label, before: classes[before[i]], after: classes[after[i]] }));
  const right = (/** @type {"before" | "after"} */ when) => judged.filter((one) => one[when] === one.label).length;
  return {
    made: { ...head, classes, map: taught },
    report: { judged, right: { before: right("before"), after: right("after") }, share: rounded(share[0], 4), classes },
  };
}
