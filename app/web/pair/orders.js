/** The orders that a head was trained for, in words. No DOM here. */

import { percent } from "../shared/text.js";

const CLOSE = 0.03; // this close to the learned p, the weights still work as trained

/** The orders that a head was trained for, as a band on the axis of p. */
export const band = ([low, high]) => [Math.max(0, low - CLOSE), Math.min(1, high + CLOSE)];

/** The meaning of moving p for this head. */
export function aboutP(learned, span, classes) {
  const chance = percent(1 / classes.length);
  if (span[1] > span[0]) {
    return `This head was trained for every p from ${span[0].toFixed(2)} to ${span[1].toFixed(2)} (shaded).`;
  }
  return `Weights stay those of the learned p = ${learned.toFixed(3)}. Shaded: the orders this head was trained for. Elsewhere the weights do not fit, and predictions are little better than guessing (${chance}), so a rise or fall there means little. Explore shows heads trained at each p.`;
}
