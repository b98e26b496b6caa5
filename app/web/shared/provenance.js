/** Where an accuracy comes from, in two sentences: head, training data, test data, what the head was given of the new
 * domain. */

import { orderText } from "./frames.js";
import { modeOf, sensorOf, worded } from "./tables.js";
import { grouped, html } from "./text.js";

/** `known` is null where a text beside it tells.
 * @param {{head: string, source: string, pairs: string, known?: string | null}} from */
export const provenance = ({ head, source, pairs, known = "nothing from these domains" }) =>
  html`<p class="provenance">Measured with ${head}, trained on ${source} and tested
    on ${pairs}.${known && ` The model was given ${known}.`}</p>`;

/** Who predicts in frames at one stop, in words. @param {Frames} frames @param {number} stop */
function predictor(frames, stop) {
  const { by, still, orders, learned, meta } = frames;
  const { seeds = [], width } = meta.head ?? {};
  if (still) return by;
  const { who = "", many = who, away = who } = modeOf(frames);
  const row = seeds.length > 1 ? many : Math.abs(orders[stop] - learned) < 5e-4 ? who : away;
  const p = `p\u00a0=\u00a0${orderText(orders[stop])}`;
  const words = worded(row, { p, n: seeds.length, head: by || "the loaded head" });
  return width ? `${words} (D\u00a0=\u00a0${width})` : words;
}

/** Return how many domains of a set with pairs its head has not learned from.
 * @param {Frames} frames */
export function strangers({ domains, source, domain }) {
  const there = new Set(domain); // a set may name domains of which it has no pair
  return domains.filter((name, i) => name !== source && there.has(i)).length;
}

/** Return the pairs that an accuracy of frames was measured on, in words. `unseen`: the summary of the domains, once
 * known.
 * @param {Frames} frames @param {{domains: {is_source?: boolean, pairs: number}[]} | null} [unseen] */
export function unseenPairs(frames, unseen) {
  const count = unseen?.domains.reduce((sum, domain) => sum + (domain.is_source ? 0 : domain.pairs), 0);
  const many = strangers(frames);
  const all = many === 1 ? "1 unseen domain" : `${many} unseen domains`;
  const mean = `${many === 1 ? "" : "mean of "}${all}`;
  return count ? `${grouped(count)} pairs (${mean})` : `the pairs of ${all}`;
}

/** Return the line below an accuracy of frames at one stop; nothing where nothing predicts.
 * @param {Frames} frames @param {number} stop @param {string} pairs @param {null} [known] */
export const ofFrames = (frames, stop, pairs, known) =>
  frames.headless || !frames.source
    ? html``
    : provenance({ head: predictor(frames, stop), source: sensorOf(frames.source), pairs, known });
