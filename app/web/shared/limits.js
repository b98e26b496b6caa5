/** What the data on the screen are, and the limits of every figure: a small panel below the words "simulated data". */

import { held } from "./held.js";
import { each, escaped, isSimulated, percent } from "./text.js";
import { theSet } from "./theset.js";

const SIMULATED =
  "<b>Simulated</b> by this project: photos and touches are rendered. No figure here is about a real sensor.";
const REAL = "<b>Real pairs</b>, according to the file’s header.";

/** Whether the pairs are simulated, in one sentence. */
const kind = ({ meta, domains }) => (meta.embeddings.simulated || domains.some(isSimulated) ? SIMULATED : REAL);

function limitsHtml(frames) {
  const { encoder, origin } = frames.meta.embeddings;
  const error = Math.max(...Object.keys(frames.meta.maps).map((name) => frames.positions(...name.split("/"), 0).error));
  const facts = [
    `${frames.pairs.toLocaleString("en-US")} pairs in ${frames.domains.length} domains. Encoder: ${escaped(encoder)}.`,
    origin && `Origin: ${escaped(origin)}.`,
    !frames.headless && `The loaded head learned from ${escaped(frames.source)} alone.`,
    !frames.headless && "Accuracy is on pairs outside the training.",
    !frames.headless && "Probabilities are calibrated on the source, and overconfident elsewhere.",
    "Each stop of p is exact; lines between are not.",
    `Map positions are at most ${percent(error, 3)} of the radius off.`,
    held ? "Your images stay in this browser." : "Of your images, the server keeps embeddings alone.",
  ];
  return `<p>${kind(frames)}</p><ul>${each(facts.filter(Boolean), (fact) => `<li>${fact}</li>`)}</ul>`;
}

/** Fill the panel when it opens. */
export function limits(panel) {
  panel.addEventListener("toggle", async () => {
    panel.innerHTML = "<p>Reading what is loaded…</p>";
    const { frames } = await theSet().catch(() => ({ frames: null }));
    panel.innerHTML = frames ? limitsHtml(frames) : `<p>${SIMULATED}</p>`;
  });
}
