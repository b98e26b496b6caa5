/** The effect of hiding parts of an image, in words. No DOM here. */

import { escaped, percent } from "../shared/text.js";

export const WORTH = 0.02; // smaller changes of the probability are not shown

/** The largest change of the probability when a part is hidden, and whether to show it. */
export function changed(drops) {
  const all = drops.flat();
  const most = Math.max(...all.map(Math.abs));
  return { most, any: most >= WORTH, needed: Math.max(...all) >= WORTH, against: Math.min(...all) <= -WORTH };
}

/** The result, in words. */
export function told(found, { most, any, needed, against }) {
  const said = `<b>${escaped(found.class)}</b>`; // without its probability: the image may be unlike anything seen
  if (!any)
    return `${said}: no single part matters. Hiding any part changes its probability by less than ${percent(Math.max(most, 0.001), 1)}.`;
  const parts = [];
  if (needed) parts.push(`orange supports <i>${escaped(found.class)}</i>`);
  if (against) parts.push("blue contradicts it");
  return `${said}: ${parts.join("; ")}. Hiding a part changes its probability by at most ${percent(most)}.`;
}
