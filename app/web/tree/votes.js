/** Nodes that give one class to nearly every pair: they say nothing about the pair in hand. No DOM here. */

import { escaped, percent } from "../shared/text.js";

export const ALIKE = 0.95; // share of pairs from which a node counts as giving one class

/** votes: [{class, share}] of the nodes; returns which of them are constant. */
export const constant = (votes) => (votes ?? []).map(({ share }) => share >= ALIKE);

/** What a tree's nodes are worth, in a sentence. */
export function worth(votes, pairs) {
  if (!votes) return "";
  const fixed = constant(votes).filter(Boolean).length;
  const names = [...new Set(votes.filter(({ share }) => share >= ALIKE).map((one) => one.class))];
  if (!fixed)
    return `Each of the ${votes.length} nodes gives different classes to different pairs of the set.`;
  const classes = names.map((name) => `<i>${escaped(name)}</i>`).join(" or ");
  return `<b>${fixed} of ${votes.length} nodes</b> (dashed) give ${classes} to at least ${percent(ALIKE)} of the set’s ${pairs.toLocaleString("en-US")} pairs, whatever the pair is. They shift every pair alike and are no directions that a new domain may lie in.`;
}
