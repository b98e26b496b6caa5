/** Where an accuracy comes from, in one line: which head, learned from what, over which pairs, what was known. */

import { escaped } from "./text.js";

/** @param {{head: string, source: string, pairs: string, known?: string}} from */
export const provenance = ({ head, source, pairs, known = "nothing" }) =>
  `<p class="provenance">By ${escaped(head)}, learned from ${escaped(source)}. Over ${escaped(pairs)}. Known of these: ${escaped(known)}.</p>`;

/** The line below the accuracy of frames in unseen domains. `unseen`: its summary, once known. */
export function ofFrames(frames, unseen) {
  const { seeds = [], width } = frames.meta.head;
  const size = width ? ` (D = ${width})` : "";
  const head = {
    retrained: `${seeds.length > 1 ? `${seeds.length} heads` : "a head"} trained at this p${size}`,
    every: `one head for every p${size}`,
    moved: `the loaded head${size}`,
  }[frames.kind];
  const others = unseen?.domains.filter((one) => !one.is_source) ?? [];
  const count = others.reduce((sum, { pairs }) => sum + pairs, 0);
  if (!head || !count || !frames.source) return "";
  const pairs = `${count.toLocaleString("en-US")} pairs of ${others.length} unseen domains, the mean of these domains`;
  return provenance({ head, source: `${frames.source} alone${asPrinted(frames)}`, pairs });
}

/** A remark on shipped heads of each p, which were trained before dots were filled: their frames name no preprocessing. */
export const asPrinted = ({ kind, meta, signals }) =>
  kind !== "moved" && !signals && !("preprocessing" in (meta.embeddings ?? {}))
    ? ", touches with their printed dots"
    : "";
