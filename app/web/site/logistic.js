/** Multinomial logistic regression with an L2 penalty, by L-BFGS, in the span of its rows. No DOM here. */

import { dot } from "./tensors.js";

const MEMORY = 20;
const MOST_STEPS = 500;

/** Rows in an orthonormal basis of their span: the lower triangle L of X Xᵀ = L Lᵀ. */
export function triangle(rows) {
  const lower = rows.map(() => new Float64Array(rows.length));
  rows.forEach((row, i) => {
    for (let j = 0; j <= i; j++) {
      const rest = dot(row, rows[j]) - dot(lower[i].subarray(0, j), lower[j]);
      lower[i][j] = i === j ? Math.sqrt(Math.max(rest, 1e-10)) : rest / lower[j][j];
    }
  });
  return lower;
}

/** Weights (K, R) of that basis as weights (K, W) of the rows' own axes. */
export function unfolded(weights, lower, rows) {
  return weights.map((weight) => {
    const left = Float64Array.from(weight);
    const out = new Float64Array(rows[0].length);
    for (let i = rows.length - 1; i >= 0; i--) {
      const share = left[i] / lower[i][i];
      for (let j = 0; j < i; j++) left[j] -= share * lower[i][j];
      for (let at = 0; at < out.length; at++) out[at] += share * rows[i][at];
    }
    return out;
  });
}

/** The mean cross-entropy of counted rows plus the penalty |W|² / (2 N), and its gradient, flat (K, R + 1). */
function objective({ rows, labels, counts, classes }, flat) {
  const wide = rows[0].length + 1;
  const total = counts.reduce((a, b) => a + b, 0);
  const slope = new Float64Array(flat.length);
  let loss = 0;
  for (let k = 0; k < classes; k++)
    for (let i = 0; i < wide - 1; i++) {
      const value = flat[k * wide + i];
      loss += (value * value) / (2 * total);
      slope[k * wide + i] = value / total;
    }
  rows.forEach((row, n) => {
    if (!counts[n]) return;
    const logits = Array.from(
      { length: classes },
      (_, k) => flat[(k + 1) * wide - 1] + dot(row, flat.subarray(k * wide, (k + 1) * wide)),
    );
    const top = Math.max(...logits);
    const sum = logits.reduce((all, value) => all + Math.exp(value - top), 0);
    loss += (counts[n] * (Math.log(sum) + top - logits[labels[n]])) / total;
    logits.forEach((value, k) => {
      const pull = (counts[n] / total) * (Math.exp(value - top) / sum - Number(k === labels[n]));
      for (let i = 0, at = k * wide; i < wide - 1; i++, at++) slope[at] += pull * row[i];
      slope[(k + 1) * wide - 1] += pull;
    });
  });
  return { loss, slope };
}

/** The direction of L-BFGS from the last steps and changes of slope. */
function downhill(slope, past) {
  const way = slope.map((value) => -value);
  const shares = [];
  for (const { step, change, curve } of past.toReversed()) {
    const share = dot(step, way) / curve;
    shares.push(share);
    for (let i = 0; i < way.length; i++) way[i] -= share * change[i];
  }
  if (past.length) {
    const { change, curve } = past.at(-1);
    const scale = curve / dot(change, change);
    for (let i = 0; i < way.length; i++) way[i] *= scale;
  }
  for (const { step, change, curve } of past) {
    const share = shares.pop() - dot(change, way) / curve;
    for (let i = 0; i < way.length; i++) way[i] += share * step[i];
  }
  return way;
}

/** Parameters (K, R + 1), flat, where no entry of the gradient is above `tolerance`.
 * problem: {rows (N, R), labels (N,), counts (N,) how often each row counts, classes} */
export function solved(problem, start = null, tolerance = 1e-4) {
  let at = start ?? new Float64Array(problem.classes * (problem.rows[0].length + 1));
  let here = objective(problem, at);
  const past = [];
  for (let turn = 0; turn < MOST_STEPS; turn++) {
    if (here.slope.every((value) => Math.abs(value) <= tolerance)) break;
    const way = downhill(here.slope, past);
    const fall = dot(way, here.slope);
    const moved = (length) => at.map((value, i) => value + length * way[i]);
    let length = 1;
    let next = moved(length);
    let there = objective(problem, next);
    while (there.loss > here.loss + 1e-4 * length * fall && length > 2e-10) {
      length /= 2;
      next = moved(length);
      there = objective(problem, next);
    }
    const step = next.map((value, i) => value - at[i]);
    const change = there.slope.map((value, i) => value - here.slope[i]);
    const curve = dot(step, change);
    if (curve > 1e-14) past.push({ step, change, curve });
    if (past.length > MEMORY) past.shift();
    [at, here] = [next, there];
  }
  return at;
}
