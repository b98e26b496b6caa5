/** What hiding parts of an image did, in words. No DOM here. */

import { escaped, percent } from "../shared/text.js";

export const WORTH = 0.02; // a smaller change of the probability is nothing to look at

/** How much the probability moves where a part is hidden, and whether that is worth showing. */
export function changed(drops) {
  const all = drops.flat();
  const most = Math.max(...all.map(Math.abs));
  return { most, any: most >= WORTH, needed: Math.max(...all) >= WORTH, against: Math.min(...all) <= -WORTH };
}

/** What was found, in words. */
export function told(found, { most, any, needed, against }) {
  const said = `<b>${escaped(found.class)} ${percent(found.probability)}</b>`;
  if (!any)
    return `${said}: no single part matters. Hiding any moves it by less than ${percent(Math.max(most, 0.001), 1)}.`;
  const parts = [];
  if (needed) parts.push(`orange supports <i>${escaped(found.class)}</i>`);
  if (against) parts.push("blue contradicts it");
  return `${said}: ${parts.join("; ")}. Hiding a part moves it by at most ${percent(most)}.`;
}
