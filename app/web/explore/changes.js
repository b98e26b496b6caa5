/** How two sets of predictions differ. No DOM here. */

/**
 * pairs: indices; left, right: pair -> predicted class; truth: pair -> class.
 * Returns the number of pairs, and of changed predictions: corrected, broken, still wrong.
 */
export function counted(pairs, left, right, truth) {
  const count = { all: 0, corrected: 0, broken: 0, wrong: 0 };
  for (const pair of pairs) {
    count.all++;
    if (left(pair) === right(pair)) continue;
    if (right(pair) === truth(pair)) count.corrected++;
    else if (left(pair) === truth(pair)) count.broken++;
    else count.wrong++;
  }
  return count;
}

const figure = (n) => n.toLocaleString("en-US");

/** The sentence below both maps. */
export function sentence({ all, corrected, broken, wrong }) {
  if (!all) return "There are no test pairs here: all are training pairs, or have a class that the head lacks.";
  return `From the left map to the right, <b>${figure(corrected + broken + wrong)}</b> of ${figure(all)} predictions change: <span class="right">${figure(corrected)} corrected</span>, <span class="wrong">${figure(broken)} broken</span>, ${figure(wrong)} still wrong.`;
}
