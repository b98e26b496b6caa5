/** The orders that a head was trained for, in words. No DOM here. */

import { percent } from "../shared/text.js";

/** The orders that a head was trained for, as a band on the axis of p: the `span` that training drew p from, or
 * what `fits` a learned p (from the frames; null before they are known, and then there is no band). */
export function band(span, fits) {
  const [low, high] = (span[1] > span[0] ? span : fits) ?? [NaN, NaN];
  return low <= high ? [Math.max(0, low), Math.min(1, high)] : null;
}

/** The meaning of moving p for this head. */
export function aboutP(learned, span, classes) {
  const chance = percent(1 / classes.length);
  if (span[1] > span[0]) {
    return `This head was trained for every p from ${span[0].toFixed(2)} to ${span[1].toFixed(2)} (shaded).`;
  }
  return `Weights stay those of the learned p = ${learned.toFixed(3)}. Shaded: the orders this head was trained for. Elsewhere the weights do not fit, and predictions are little better than guessing (${chance}), so a rise or fall there means little. Explore shows heads trained at each p.`;
}
