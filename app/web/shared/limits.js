/** What the data on the screen are, and the limits of every figure: a small panel below the words "simulated data". */

import { held } from "./held.js";
import { grouped, html, isSimulated, percent, put } from "./text.js";
import { theSet } from "./theset.js";

const SIMULATED = html`These data are <b>simulated</b>: this project rendered all photos and touches. No figure on this
  page describes a real sensor.`;
const REAL = html`These are <b>real pairs</b>, according to the header of the file.`;

/** Return what limits the figures of a set, one sentence each. @param {Frames} frames */
function limitsOf(frames) {
  const { pairs, domains, headless, source, meta } = frames;
  const { encoder, origin, simulated } = meta.embeddings;
  const facts = [
    `${grouped(pairs)} pairs in ${domains.length} domains. Encoder: ${encoder}.`,
    origin && `Origin of the data: ${origin}.`,
    !headless && `The loaded head was trained on ${source} only.`,
    !headless && "Accuracy is measured on pairs that were not used for training.",
    !headless && "Probabilities are calibrated on the training domain. In other domains they are too high.",
    "Each stop of p is exact. Lines between stops are interpolated.",
    `Map positions are rounded by at most ${percent(frames.error, 3)} of the radius of the map.`,
    held ? "Your images stay in this browser." : "The server does not store your images, only their feature vectors.",
  ];
  return html`<p>${simulated || domains.some(isSimulated) ? SIMULATED : REAL}</p>
    <ul>${facts.filter(Boolean).map((fact) => html`<li>${fact}</li>`)}</ul>`;
}

/** Fill the panel when it opens. @param {HTMLElement} panel */
export function limits(panel) {
  panel.addEventListener("toggle", async () => {
    put(panel, html`<p>Loading…</p>`);
    const set = await theSet().catch(() => null);
    put(panel, set ? limitsOf(set.frames) : html`<p>${SIMULATED}</p>`);
  });
}
