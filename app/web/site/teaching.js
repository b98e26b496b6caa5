/** Teaching from a visitor's labelled pairs, as `omnivat/head/teach.py` does it. No DOM here. */

import { imagesOf } from "../shared/images.js";
import { Refused } from "./refusal.js";
import { TEACHING } from "./rules.js";
import { best, dot, rounded, rowOf, softmax, sum } from "./tensors.js";

const { MOST_LESSONS, LONGEST_LABEL, PENALTY, SHARPNESS, FOLDS, FEWEST } = TEACHING;
/** @typedef {number[][]} Matrix @typedef {{ rows: Floats[], targets: Matrix, before: Matrix }} Room lessons: their
 * rows, labels one-hot, and the head's prediction */

/** The labelled pairs of a question. @param {{ lessons?: Lesson[] }} question */
export function lessonsIn({ lessons = [] }) {
  const all = lessons.map((one) => ({ ...one, label: one.label.trim() }));
  if (all.length > MOST_LESSONS)
    throw new Refused(`${all.length} pairs are labelled, and at most ${MOST_LESSONS} are taught here.`);
  const wrong = all.find(({ label }) => !label || label.length > LONGEST_LABEL);
  if (wrong) throw new Refused(`A label is '${wrong.label}'; give a name of 1 to ${LONGEST_LABEL} letters.`);
  return all;
}

/** Readings with what lessons add, from the readings before any; one image alone counts twice.
 * @param {LessonMap} map @param {Record<string, number[]>} before @param {Tensors} out */
export function withLessons({ rows, bias, share }, before, out) {
  const shares = Object.entries(before).map(([reading, shown]) => {
    const image = reading.replace("_branch", "");
    const there = image === "fused" ? imagesOf(before) : [image];
    const row = standing(out, there).map((value) => (2 / there.length) * value);
    return [reading, softmax(rows.map((one, k) => share * (shown[k] ?? 0) + dot(one, row) + bias[k]))];
  });
  return Object.fromEntries(shares);
}

/** What is missing before lessons can be judged, or "". @param {{ label: string }[]} lessons */
export function missing(lessons) {
  /** @type {Map<string, number>} */
  const counts = new Map();
  for (const { label } of lessons) counts.set(label, (counts.get(label) ?? 0) + 1);
  if ([...counts.values()].filter((count) => count >= FEWEST).length >= FEWEST) return "";
  const there = [...counts].map((one) => one.join(" ")).join(", ") || "none yet";
  return `Label two or more pairs of each of two or more classes first, of different objects; there are: ${there}.`;
}

/** VIS and TAC of a head's outputs side by side; the part of a missing image is zero.
 * @param {Tensors} out @param {string[]} there */
function standing(out, there) {
  const width = out.vis_standing.values.length;
  const row = new Float64Array(2 * width);
  for (const name of there) row.set(out[`${name}_standing`].values, name === "vis" ? 0 : width);
  return row;
}

/** The inverse of a positive definite matrix, in its place, by Gauss-Jordan elimination. @param {Float64Array[]} matrix */
function inverted(matrix) {
  matrix.forEach((row, k) => {
    const pivot = row[k];
    row[k] = 1;
    for (let j = 0; j < row.length; j++) row[j] /= pivot;
    matrix.forEach((other, i) => {
      const share = other[k];
      if (i === k) return;
      other[k] = 0;
      for (let j = 0; j < row.length; j++) other[j] -= share * row[j];
    });
  });
  return matrix;
}

/** The ridge regression of values (L, K) on L rows: the weight of each row, `solved`, and its error without it.
 * See omnivat/head/ridge.py. @param {Floats[]} rows @param {Matrix} values */
export function ridge(rows, values) {
  const inverse = inverted(
    rows.map((row, i) => Float64Array.from(rows, (other, j) => dot(row, other) + 1 + (i === j ? PENALTY : 0))),
  );
  const solved = inverse.map((row) => values[0].map((_, k) => sum(values.map((value, j) => row[j] * value[k]))));
  return { solved, errors: solved.map((row, i) => row.map((value) => value / inverse[i][i])) };
}

/** The head's share, 0 to 1, from the errors (L, K) of labels and of the head's prediction.
 * @param {Matrix} labels @param {Matrix} head */
function shareOf(labels, head) {
  const size = sum(head.map((row) => dot(row, row)));
  const one = size / head.length; // the head counts as right on one object more
  const fit = sum(labels.map((row, i) => dot(row, head[i])));
  return Math.min(1, Math.max(0, (fit + one) / (size + one)));
}

/** The factor of scores (L, K) whose softmax has the least log loss, with one more lesson of every class alike.
 * @param {Matrix} scores @param {number[]} labels */
export function sharpness(scores, labels) {
  let [low, high] = SHARPNESS;
  for (let turn = 0; turn < 40; turn++) {
    const factor = (low + high) / 2;
    const slopes = scores.map((row, i) => {
      const mean = dot(softmax(row.map((score) => factor * score)), row);
      return mean - row[labels[i]] + (mean - sum(row) / row.length) / scores.length;
    });
    if (sum(slopes) < 0) low = factor;
    else high = factor;
  }
  return high;
}

/** a - share * b. @param {Matrix} a @param {number} share @param {Matrix} b */
const less = (a, share, b) => a.map((row, i) => row.map((value, k) => value - share * b[i][k]));

/** What lessons teach: the head's share, the weight of each lesson, and the scores of each without it.
 * @param {Room} room */
export function solved({ rows, targets, before }) {
  const [wanted, shown] = [ridge(rows, targets), ridge(rows, before)];
  const share = shareOf(wanted.errors, shown.errors);
  const apart = less(targets, 1, less(wanted.errors, share, shown.errors));
  return { share, weights: less(wanted.solved, share, shown.solved), apart };
}

/** The class of each lesson by what the other folds teach; a fold has one lesson of each class, or a tenth of it.
 * @param {Room} room @param {number[]} labels */
export function afterOf(room, labels) {
  const places = labels.map((label, i) => labels.slice(0, i).filter((other) => other === label).length);
  const counts = labels.map((label) => labels.filter((other) => other === label).length);
  const most = Math.min(FOLDS, Math.max(...counts));
  const folds = places.map((at, i) => Math.floor((at * most) / counts[i]));
  const heads = Array.from({ length: most }, (_, fold) => {
    /** @template T @param {T[]} all */
    const others = (all) => all.filter((__, i) => folds[i] !== fold);
    const rest = { rows: others(room.rows), targets: others(room.targets), before: others(room.before) };
    return { rows: rest.rows, ...solved(rest) };
  });
  return labels.map((_, i) => {
    const { rows, share, weights } = heads[folds[i]];
    const near = rows.map((row) => dot(row, room.rows[i]) + 1);
    return best(room.before[i].map((value, k) => share * value + sum(near.map((one, j) => one * weights[j][k]))));
  });
}

/** Teach lessons: the taught head, and the report, what is said of each lesson before and after teaching by the others.
 * @param {{ head: SiteHead, lessons: TaughtPair[], run: (pair: Rows) => Promise<Tensors> }} school */
export async function teach({ head, lessons, run }) {
  const names = lessons.map(({ label }) => label);
  const classes = [...new Set([...head.classes, ...names])];
  const labels = names.map((name) => classes.indexOf(name));
  /** @type {Room} */
  const room = { rows: [], before: [], targets: labels.map((label) => classes.map((_, k) => Number(k === label))) };
  for (const { pair } of lessons) {
    const [out, there] = [await run(pair), imagesOf(pair)];
    const shown = rowOf(out[there.length > 1 ? "p_fused" : `p_${there[0]}`], 0);
    room.rows.push(standing(out, there));
    room.before.push(classes.map((_, k) => shown[k] ?? 0));
  }
  const { share, weights, apart } = solved(room);
  const sharp = sharpness(apart, labels);
  const after = missing(lessons) ? [] : afterOf(room, labels);
  const judged = names.map((label, i) => ({ label, before: classes[best(room.before[i])], after: classes[after[i]] }));
  const right = (/** @type {"before" | "after"} */ when) => judged.filter((one) => one[when] === one.label).length;
  const report = { judged, right: { before: right("before"), after: right("after") }, share: rounded(share, 4) };
  const weighted = (/** @type {number} */ k, /** @type {number} */ at) =>
    sharp * sum(room.rows.map((row, i) => weights[i][k] * row[at]));
  const map = {
    rows: classes.map((_, k) => room.rows[0].map((__, at) => weighted(k, at))),
    bias: classes.map((_, k) => sharp * sum(weights.map((row) => row[k]))),
    share: sharp * share,
  };
  return { made: { ...head, classes, map }, report };
}
