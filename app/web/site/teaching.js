/** Teaching from a visitor's labelled pairs, as `omnivat/head/teach.py` does it. No DOM here. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Refused } from "./refusal.js";
import { best, dot, mean, rowOf, softmax, sum, unit } from "./tensors.js";

const MOST_LESSONS = 60;
const LONGEST_LABEL = 40;
const WEIGHT = 10; // of a class's lessons together, in training pairs
const SHARPNESS = [0.5, 50]; // least and most, of scores
const PARTS = ["training pairs and lessons", "lessons alone"];

/** The labelled pairs of a question. */
export function lessonsIn({ lessons }) {
  const all = (lessons ?? []).map((one) => ({ ...one, label: one.label.trim() }));
  if (all.length > MOST_LESSONS)
    throw new Refused(`${all.length} pairs are labelled, and at most ${MOST_LESSONS} are taught here.`);
  const wrong = all.find(({ label }) => !label || label.length > LONGEST_LABEL);
  if (wrong) throw new Refused(`A label is '${wrong.label}'; give a name of 1 to ${LONGEST_LABEL} letters.`);
  return all;
}

/** The readings of a head with taught rows: a class has the largest score of its rows. */
export function scoresOf({ rows, bias, owner, classes }, out, there) {
  const part = (name, at) => {
    const own = out[`${name}_standing`].values;
    const from = name === "vis" ? 0 : own.length;
    return dot(own, rows[at].subarray(from, from + own.length));
  };
  const shares = (score) => {
    const logits = classes.map(() => Number.NEGATIVE_INFINITY);
    owner.forEach((label, at) => (logits[label] = Math.max(logits[label], score(at) + bias[at])));
    return softmax(logits);
  };
  const alone = Object.fromEntries(there.map((name) => [name, shares((at) => 2 * part(name, at))]));
  if (there.length === 1) return { fused: alone[there[0]], ...alone };
  const fused = shares((at) => part("vis", at) + part("tac", at));
  return { fused, ...alone, vis_branch: alone.vis, tac_branch: alone.tac };
}

/** What is missing before lessons can be judged, or "". */
export function missing(lessons) {
  const counts = new Map();
  for (const { label } of lessons) counts.set(label, (counts.get(label) ?? 0) + 1);
  if ([...counts.values()].filter((count) => count >= 2).length >= 2) return "";
  const there = [...counts].map((one) => one.join(" ")).join(", ") || "none yet";
  return `Label two or more pairs of each of two or more classes first, of different objects; there are: ${there}.`;
}

const known = new WeakMap(); // training embeddings -> their rows

/** The training pairs as rows {row, label}; none for a head without them. */
async function trainingRows({ known: kept, run }) {
  if (!kept?.labels || IMAGES.some((name) => !kept[`${name}_lengths`])) return [];
  if (known.has(kept)) return known.get(kept);
  const found = [];
  for (const [at, label] of kept.labels.values.entries()) {
    const raw = (name) => rowOf(kept[name], at).map((value) => value * kept[`${name}_lengths`].values[at]);
    const out = await run({ vis: raw("vis"), tac: raw("tac") });
    found.push({ row: standing(out, IMAGES), label });
  }
  known.set(kept, found);
  return found;
}

/** VIS and TAC side by side; the part of a missing image is zero. */
function standing(out, there) {
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

/** The ridge regression of one-hot labels on counted rows: `weights` (K, W), `bias` (K), and for each of the first
 * `lessons` rows `errors` (L, K) of the regression without it. See omnivat/head/ridge.py. */
export function ridge(rows, labels, counts, classes, lessons) {
  const matrix = rows.map(() => new Float64Array(rows.length));
  rows.forEach((row, i) => {
    for (let j = 0; j <= i; j++) matrix[i][j] = matrix[j][i] = dot(row, rows[j]) + 1;
    matrix[i][i] += 1 / counts[i];
  });
  const inverse = inverted(matrix);
  const shares = Array.from({ length: classes }, (_, k) =>
    inverse.map((row) => sum(row.filter((_, j) => labels[j] === k))),
  );
  const weights = shares.map((share) => {
    const weight = new Float64Array(rows[0].length);
    rows.forEach((row, i) => row.forEach((value, at) => (weight[at] += share[i] * value)));
    return weight;
  });
  const errors = inverse.slice(0, lessons).map((row, i) => shares.map((share) => share[i] / row[i]));
  return { weights, bias: shares.map(sum), errors };
}

/** t with the least squared error of (1 - t) both + t lessons, of errors (L, K). */
export function shareOf(both, lessons) {
  const pairs = both.flatMap((row, i) => row.map((error, k) => [error, error - lessons[i][k]]));
  const top = sum(pairs.map(([error, apart]) => error * apart));
  return Math.min(1, Math.max(0, top / Math.max(1e-12, sum(pairs.map(([, apart]) => apart * apart)))));
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

const blended = (share, both, lessons) => both.map((value, i) => (1 - share) * value + share * lessons[i]);
const scored = (label, errors) => errors.map((error, k) => Number(label === k) - error);

/** Teach the lessons of a room {head, lessons: [{label, pair}], known, run(pair, head)}: the taught head, with a row and a
 * bias of each class that has pairs and directions of new classes, and the report, what is said of each lesson before
 * and after teaching by the others. */
export async function teach(room) {
  const { head, lessons, run } = room;
  const names = lessons.map(({ label }) => label);
  const classes = [...new Set([...head.classes, ...names])];
  const labels = names.map((name) => classes.indexOf(name));
  const source = await trainingRows(room);
  const outs = [];
  for (const { pair } of lessons) outs.push({ out: await run(pair), there: imagesOf(pair) });
  const rows = outs.map(({ out, there }) => standing(out, there));
  const weight = Math.max(1, (WEIGHT * new Set(labels).size) / labels.length);
  const [both, alone] = [source, source.filter(({ label }) => !labels.includes(label))].map((some) =>
    ridge(
      [...rows, ...some.map(({ row }) => row)],
      [...labels, ...some.map(({ label }) => label)],
      [...rows.map(() => weight), ...some.map(() => 1)],
      classes.length,
      rows.length,
    ),
  );
  const present = [...new Set([...source.map(({ label }) => label), ...labels])].sort((a, b) => a - b);
  const share = missing(lessons) ? 0 : shareOf(both.errors, alone.errors);
  const scores = (by, i) => scored(labels[i], blended(by, both.errors[i], alone.errors[i]));
  const sharp = sharpness(
    labels.map((_, i) => scores(share, i)),
    labels,
  );
  const direction = (k) => {
    const hats = outs.filter((_, i) => labels[i] === k).flatMap(hatsOf);
    const middle = unit(hats[0].map((_, at) => mean(hats.map((hat) => hat[at]))));
    return Array.from(middle, (value) => head.scale * value);
  };
  const made = {
    ...head,
    classes,
    directions: classes.map((_, k) => head.directions[k] ?? direction(k)),
    rows: present.map((k) => blended(share, both.weights[k], alone.weights[k]).map((value) => sharp * value)),
    bias: present.map((k) => sharp * ((1 - share) * both.bias[k] + share * alone.bias[k])),
    owner: present,
  };
  const top = (row) => present[best(present.map((k) => row[k]))];
  const others = (i, errors) => errors.filter((_, at) => at !== i);
  const judged = lessons.map(({ label }, i) => ({
    label,
    before: head.classes[best(saidOf(outs[i]))],
    after: classes[top(scores(shareOf(others(i, both.errors), others(i, alone.errors)), i))],
  }));
  const right = (when) => judged.filter((one) => one[when] === one.label).length;
  const parts = [0, 1].map((by) => labels.filter((label, i) => top(scores(by, i)) === label).length);
  const report = {
    judged,
    right: { before: right("before"), after: right("after") },
    share: Math.round(1e4 * share) / 1e4,
    parts: Object.fromEntries(PARTS.map((name, i) => [name, parts[i]])),
  };
  return { made, report };
}
const hatsOf = ({ out, there }) =>
  there.map((name) => unit(rowOf(out[there.length > 1 ? `${name}_f_hat` : `${name}_alone`], 0)));
const saidOf = ({ out, there }) => rowOf(out[there.length > 1 ? "p_fused" : `p_${there[0]}`], 0);
