/** Nodes that alone predict one class for nearly every pair. No DOM here. */

import { escaped, percent } from "../shared/text.js";

export const ALIKE = 0.95; // from this share of pairs on, a node counts as constant

/** votes: [{class, share}] of the nodes; returns the constant ones. */
export const constant = (votes) => (votes ?? []).map(({ share }) => share >= ALIKE);

/** A sentence about the constant nodes of a tree. */
export function worth(votes, pairs) {
  if (!votes) return "";
  const fixed = constant(votes).filter(Boolean).length;
  const names = [...new Set(votes.filter(({ share }) => share >= ALIKE).map((one) => one.class))];
  if (!fixed) return `Each of the ${votes.length} nodes alone predicts different classes for different pairs.`;
  const classes = names.map((name) => `<i>${escaped(name)}</i>`).join(" or ");
  return `<b>${fixed} of ${votes.length} nodes</b> (dashed) alone predict ${classes} for at least ${percent(ALIKE)} of the set’s ${pairs.toLocaleString("en-US")} pairs.`;
}
