/** Where an accuracy comes from, in one line: which head, learned from what, over which pairs, what was known. */

import { orderText } from "./frames.js";
import { modeOf, worded } from "./tables.js";
import { escaped } from "./text.js";

/** @param {{head: string, source: string, pairs: string, known?: string}} from */
export const provenance = ({ head, source, pairs, known = "nothing" }) =>
  `<p class="provenance">By ${escaped(head)}, from ${escaped(source)}; ${escaped(pairs)}; known: ${escaped(known)}.</p>`;

/** Who predicts in frames at one stop, in words. */
function predictor(frames, stop) {
  const { by, still, orders, learned, meta } = frames;
  const { seeds = [], width } = meta.head ?? {};
  if (still) return by;
  const { who, many = who, away = who } = modeOf(frames);
  const row = seeds.length > 1 ? many : Math.abs(orders[stop] - learned) < 5e-4 ? who : away;
  const p = `p\u00a0=\u00a0${orderText(orders[stop])}`;
  const words = worded(row, { p, n: seeds.length, head: by || "the loaded head" });
  return width ? `${words} (D\u00a0=\u00a0${width})` : words;
}

/** How many domains of a set with pairs its head has not learned from. */
export function strangers({ domains, source, domain }) {
  const there = new Set(domain); // a set may name domains of which it has no pair
  return domains.filter((name, i) => name !== source && (!domain || there.has(i))).length;
}

/** The pairs that an accuracy of frames is over, in words. `unseen`: the summary of the domains, once known. */
export function unseenPairs(frames, unseen) {
  const count = unseen?.domains.reduce((sum, one) => sum + (one.is_source ? 0 : one.pairs), 0);
  const many = strangers(frames);
  const mean = `mean of ${many} unseen domain${many === 1 ? "" : "s"}`;
  return count ? `${mean}, ${count.toLocaleString("en-US")} pairs` : mean;
}

/** The line below an accuracy of frames at one stop; "" where nothing predicts. */
export const ofFrames = (frames, stop, pairs) =>
  frames.headless || !frames.source ? "" : provenance({ head: predictor(frames, stop), source: frames.source, pairs });
