/** How two sets of predictions differ. No DOM here. */

import { escaped } from "../shared/text.js";

/**
 * pairs: indices; left, right: pair -> predicted class; truth: pair -> class.
 * Returns the number of pairs, and of changed predictions: corrected, broken, still wrong.
 */
export function counted(pairs, left, right, truth) {
  const found = { all: 0, corrected: 0, broken: 0, wrong: 0 };
  for (const pair of pairs) {
    found.all++;
    if (left(pair) === right(pair)) continue;
    if (right(pair) === truth(pair)) found.corrected++;
    else if (left(pair) === truth(pair)) found.broken++;
    else found.wrong++;
  }
  return found;
}

const figure = (n) => n.toLocaleString("en-US");

/** The sentence above both maps. */
export function sentence(names, { all, corrected, broken, wrong }) {
  const [left, right] = names.map(escaped);
  if (left === right)
    return `Both sides show ${left}, with the same predictions. Choose another head or p for one of them.`;
  if (!all) return "There are no test pairs here: all are training pairs, or have a class that the head lacks.";
  const changed = corrected + broken + wrong;
  return `From ${left} (left) to ${right} (right), <b>${figure(changed)}</b> of ${figure(all)} predictions change: <span class="right">${figure(corrected)} corrected</span>, <span class="wrong">${figure(broken)} broken</span>, ${figure(wrong)} still wrong.`;
}

/** The difference of a measure from the left side: signed, without judgement; shares differ in points. */
export function difference(own, other, share = false) {
  const off = own - other;
  if (!Number.isFinite(off)) return "";
  const size = share ? `${(100 * Math.abs(off)).toFixed(1)} points` : Math.abs(off).toFixed(3);
  return `${off >= 0 ? "+" : "−"}${size}`;
}
