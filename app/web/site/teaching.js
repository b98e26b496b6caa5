/** Teaching from a visitor's labelled pairs, as `omnivat/head/teach.py` does it. No DOM here. */

import { imagesOf } from "../shared/images.js";
import { Refused } from "./refusal.js";
import { best, dot, rowOf, softmax, sum } from "./tensors.js";

const MOST_LESSONS = 60;
const LONGEST_LABEL = 40;
const PENALTY = 0.3; // of squared weights
const SHARPNESS = [0.5, 50]; // least and most, of scores
const FOLDS = 10; // of the lessons of a class, at most

/** The labelled pairs of a question. */
export function lessonsIn({ lessons }) {
  const all = (lessons ?? []).map((one) => ({ ...one, label: one.label.trim() }));
  if (all.length > MOST_LESSONS)
    throw new Refused(`${all.length} pairs are labelled, and at most ${MOST_LESSONS} are taught here.`);
  const wrong = all.find(({ label }) => !label || label.length > LONGEST_LABEL);
  if (wrong) throw new Refused(`A label is '${wrong.label}'; give a name of 1 to ${LONGEST_LABEL} letters.`);
  return all;
}

/** Readings with what lessons add, from the readings before any; one image alone counts twice. */
export function withLessons({ rows, bias, share }, before, out) {
  const there = imagesOf(before);
  const part = (name, row) => {
    const own = out[`${name}_standing`].values;
    const from = name === "vis" ? 0 : own.length;
    return dot(own, row.subarray(from, from + own.length));
  };
  const added = (reading) => {
    const image = reading.replace("_branch", "");
    const names = image === "fused" ? there : [image];
    return (row) => (2 / names.length) * sum(names.map((name) => part(name, row)));
  };
  const shares = ([reading, shown]) => {
    const score = added(reading);
    return [reading, softmax(rows.map((row, k) => share * (shown[k] ?? 0) + score(row) + bias[k]))];
  };
  return Object.fromEntries(Object.entries(before).map(shares));
}

/** What is missing before lessons can be judged, or "". */
export function missing(lessons) {
  const counts = new Map();
  for (const { label } of lessons) counts.set(label, (counts.get(label) ?? 0) + 1);
  if ([...counts.values()].filter((count) => count >= 2).length >= 2) return "";
  const there = [...counts].map((one) => one.join(" ")).join(", ") || "none yet";
  return `Label two or more pairs of each of two or more classes first, of different objects; there are: ${there}.`;
}

/** VIS and TAC side by side; the part of a missing image is zero. */
function standing({ out, there }) {
  const width = out.vis_standing.values.length;
  const row = new Float64Array(2 * width);
  for (const name of there) row.set(out[`${name}_standing`].values, name === "vis" ? 0 : width);
  return row;
}

/** The inverse of a positive definite matrix, in its place, by Gauss-Jordan elimination. */
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
 * See omnivat/head/ridge.py. */
export function ridge(rows, values) {
  const inverse = inverted(
    rows.map((row, i) => Float64Array.from(rows, (other, j) => dot(row, other) + 1 + (i === j ? PENALTY : 0))),
  );
  const solved = inverse.map((row) => values[0].map((_, k) => sum(values.map((value, j) => row[j] * value[k]))));
  return { solved, errors: solved.map((row, i) => row.map((value) => value / inverse[i][i])) };
}

/** The head's share, 0 to 1, from the errors (L, K) of labels and of the head's prediction. */
export function shareOf(labels, head) {
  const size = sum(head.map((row) => dot(row, row)));
  const one = size / head.length; // the head counts as right on one object more
  const fit = sum(labels.map((row, i) => dot(row, head[i])));
  return Math.min(1, Math.max(0, (fit + one) / (size + one)));
}

/** The factor of scores (L, K) whose softmax has the least log loss, with one more lesson of every class alike. */
export function sharpness(scores, labels) {
  let [low, high] = SHARPNESS;
  for (let turn = 0; turn < 40; turn++) {
    const factor = (low + high) / 2;
    const means = scores.map((row) => dot(softmax(row.map((score) => factor * score)), row));
    const slope = sum(
      means.map((mean, i) => mean - scores[i][labels[i]] + (mean - sum(scores[i]) / scores[i].length) / scores.length),
    );
    if (slope < 0) low = factor;
    else high = factor;
  }
  return high;
}

/** a - share * b, of matrices. */
const less = (a, share, b) => a.map((row, i) => row.map((value, k) => value - share * b[i][k]));

/** What lessons teach: the head's share, the weight of each lesson, and the scores of each without it. */
export function solved({ rows, targets, before }) {
  const [wanted, shown] = [ridge(rows, targets), ridge(rows, before)];
  const share = shareOf(wanted.errors, shown.errors);
  const apart = less(targets, 1, less(wanted.errors, share, shown.errors));
  return { share, weights: less(wanted.solved, share, shown.solved), apart };
}

/** The fold of each lesson: folds have one lesson of each class, or a tenth of it. */
function foldsOf(labels) {
  const of = (label) => labels.filter((other) => other === label).length;
  const folds = Math.min(FOLDS, Math.max(...labels.map(of)));
  const at = (label, i) => labels.slice(0, i).filter((other) => other === label).length;
  return labels.map((label, i) => Math.floor((at(label, i) * folds) / of(label)));
}

/** The class of each lesson by what the other folds teach. */
export function afterOf(room, labels) {
  const folds = foldsOf(labels);
  const taught = (fold) => {
    const rest = labels.flatMap((_, i) => (folds[i] === fold ? [] : [i]));
    const [rows, targets, before] = [room.rows, room.targets, room.before].map((all) => rest.map((i) => all[i]));
    return { rows, ...solved({ rows, targets, before }) };
  };
  const heads = [...new Set(folds)].sort((a, b) => a - b).map(taught);
  return labels.map((_, i) => {
    const { rows, share, weights } = heads[folds[i]];
    const near = rows.map((row) => dot(row, room.rows[i]) + 1);
    return best(room.before[i].map((value, k) => share * value + sum(near.map((one, j) => one * weights[j][k]))));
  });
}

/** Teach the lessons of a room {head, lessons: [{label, pair}], run(pair)}: the taught head, and the report, what is
 * said of each lesson before and after teaching by the others. */
export async function teach({ head, lessons, run }) {
  const names = lessons.map(({ label }) => label);
  const classes = [...new Set([...head.classes, ...names])];
  const labels = names.map((name) => classes.indexOf(name));
  const outs = [];
  for (const { pair } of lessons) outs.push({ out: await run(pair), there: imagesOf(pair) });
  const rows = outs.map(standing);
  const targets = labels.map((label) => classes.map((_, k) => Number(k === label)));
  const before = outs.map((one) => classes.map((_, k) => predicted(one)[k] ?? 0));
  const { share, weights, apart } = solved({ rows, targets, before });
  const sharp = sharpness(apart, labels);
  const after = missing(lessons) ? [] : afterOf({ rows, targets, before }, labels);
  const judged = names.map((label, i) => ({ label, before: classes[best(before[i])], after: classes[after[i]] }));
  const right = (when) => judged.filter((one) => one[when] === one.label).length;
  const report = {
    judged,
    right: { before: right("before"), after: right("after") },
    share: Math.round(1e4 * share) / 1e4,
  };
  const map = {
    rows: classes.map((_, k) => rows[0].map((_, at) => sharp * sum(rows.map((row, i) => weights[i][k] * row[at])))),
    bias: classes.map((_, k) => sharp * sum(weights.map((row) => row[k]))),
    share: sharp * share,
  };
  return { made: { ...head, classes, map }, report };
}
const predicted = ({ out, there }) => rowOf(out[there.length > 1 ? "p_fused" : `p_${there[0]}`], 0);
