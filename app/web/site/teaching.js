/** Teaching from a visitor's labelled pairs, which `lessons.onnx` solves; see omnivat/head/teach.py. No DOM here. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { PAIR } from "./rules.js";
import { best, dot, rounded, rowOf, softmax } from "./tensors.js";

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

/** Readings with what lessons add, from the readings before any; one image alone counts twice.
 * @param {NonNullable<SiteHead["map"]>} map @param {Record<string, number[]>} before @param {Tensors} out */
export function withLessons({ rows, bias, share }, before, out) {
  const shares = Object.entries(before).map(([reading, shown]) => {
    const image = reading.replace("_branch", "");
    const there = image === "fused" ? imagesOf(before) : [image];
    const row = standing(out, there).map((value) => (2 / there.length) * value);
    return [reading, softmax(rows.map((one, k) => share * (shown[k] ?? 0) + dot(one, row) + bias[k]))];
  });
  return Object.fromEntries(shares);
}

/** VIS and TAC of a head's outputs side by side; the part of a missing image is zero.
 * @param {Tensors} out @param {string[]} there */
function standing(out, there) {
  return IMAGES.flatMap((name) =>
    Array.from(rowOf(out[`${name}_standing`], 0), (value) => (there.includes(name) ? value : 0)),
  );
}

/** Teach lessons: the taught head, and the report, what is said of each lesson before and after teaching by the others.
 * @param {import("./models.js").Models} models @param {SiteHead} head @param {{ label: string, pair: Rows }[]} lessons */
export async function teach(models, head, lessons) {
  const names = lessons.map(({ label }) => label);
  const classes = [...new Set([...head.classes, ...names])];
  const [rows, before] = [/** @type {number[][]} */ ([]), /** @type {number[][]} */ ([])];
  for (const { pair } of lessons) {
    const [out, there] = [await models.run(head, [pair], [null]), imagesOf(pair)];
    const shown = rowOf(out[there.length > 1 ? "p_fused" : `p_${there[0]}`], 0);
    rows.push(standing(out, there));
    before.push(classes.map((_, k) => shown[k] ?? 0));
  }
  const labels = BigInt64Array.from(names, (name) => BigInt(classes.indexOf(name)));
  /** @param {number[][]} all @returns {any[]} */
  const matrix = (all) => ["float64", Float64Array.from(all.flat()), [all.length, all[0].length]];
  const feeds = { rows: matrix(rows), labels: ["int64", labels, [names.length]], before: matrix(before) };
  const out = await models.ran("../lessons.onnx", "", feeds);
  const after = Array.from(out.after.values, Number);
  const judged = names.map((label, i) => ({ label, before: classes[best(before[i])], after: classes[after[i]] }));
  const right = (/** @type {"before" | "after"} */ when) => judged.filter((one) => one[when] === one.label).length;
  const map = { rows: classes.map((_, k) => rowOf(out.map, k)), bias: out.bias.values, share: out.factor.values[0] };
  return {
    made: { ...head, classes, map },
    report: {
      judged,
      right: { before: right("before"), after: right("after") },
      share: rounded(out.share.values[0], 4),
      classes,
    },
  };
}
