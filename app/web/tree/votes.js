/** Nodes that give one class to nearly every pair, and so depend little on the pair. No DOM here. */

import { escaped, percent } from "../shared/text.js";

export const ALIKE = 0.95; // from this share of pairs on, a node counts as constant

/** votes: [{class, share}] of the nodes; returns the constant ones. */
export const constant = (votes) => (votes ?? []).map(({ share }) => share >= ALIKE);

/** A sentence about the constant nodes of a tree. */
export function worth(votes, pairs) {
  if (!votes) return "";
  const fixed = constant(votes).filter(Boolean).length;
  const names = [...new Set(votes.filter(({ share }) => share >= ALIKE).map((one) => one.class))];
  if (!fixed)
    return `Each of the ${votes.length} nodes gives different classes to different pairs of the set.`;
  const classes = names.map((name) => `<i>${escaped(name)}</i>`).join(" or ");
  return `<b>${fixed} of ${votes.length} nodes</b> (dashed) give ${classes} to at least ${percent(ALIKE)} of the set’s ${pairs.toLocaleString("en-US")} pairs, whatever the pair is. They shift all pairs in the same way, so they do not represent directions towards new domains.`;
}
