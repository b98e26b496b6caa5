/** What the data on the screen are, and the limits of every figure: a small panel below the words "simulated data". */

import { held } from "./held.js";
import { html, isSimulated, percent, put } from "./text.js";
import { theSet } from "./theset.js";

const SIMULATED = html`<b>Simulated</b> by this project: photos and touches are rendered. No figure here is about a real sensor.`;
const REAL = html`<b>Real pairs</b>, according to the file’s header.`;

/** @param {Frames} frames */
function limitsOf(frames) {
  const { pairs, domains, headless, source, meta } = frames;
  const { encoder, origin, simulated } = meta.embeddings;
  const error = Math.max(
    ...Object.keys(meta.maps).map((name) => {
      const [kind, stage] = name.split("/");
      return frames.positions(kind, stage, 0).error;
    }),
  );
  const facts = [
    `${pairs.toLocaleString("en-US")} pairs in ${domains.length} domains. Encoder: ${encoder}.`,
    origin && `Origin: ${origin}.`,
    !headless && `The loaded head learned from ${source} alone.`,
    !headless && "Accuracy is on pairs outside the training.",
    !headless && "Probabilities are calibrated on the source, and overconfident elsewhere.",
    "Each stop of p is exact; lines between are not.",
    `Map positions are at most ${percent(error, 3)} of the radius off.`,
    held ? "Your images stay in this browser." : "Of your images, the server keeps embeddings alone.",
  ];
  return html`<p>${simulated || domains.some(isSimulated) ? SIMULATED : REAL}</p>
    <ul>${facts.filter(Boolean).map((fact) => html`<li>${fact}</li>`)}</ul>`;
}

/** Fill the panel when it opens. @param {HTMLElement} panel */
export function limits(panel) {
  panel.addEventListener("toggle", async () => {
    put(panel, html`<p>Reading what is loaded…</p>`);
    const set = await theSet().catch(() => null);
    put(panel, set ? limitsOf(set.frames) : html`<p>${SIMULATED}</p>`);
  });
}
