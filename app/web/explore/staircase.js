/** The steps of the head as a flow, with stairs of a gap or the margin; each step opens its map. */

import { asText, axis, gapsOf, values } from "../shared/measures.js";
import { checked } from "../shared/radios.js";
import { stepsOf } from "../shared/stages.js";
import { $, draw, html, options, scene, state } from "./root.js";

const HIGH = 33; // CSS pixels of a row of stairs
const WORDS = 16; // of these, above the highest step, for its figure

/** Return a letter, with its index below it. @param {string} short */
const symbol = (short) => html`${short.replace("_p", "")}${short.endsWith("_p") && html`<sub>p</sub>`}`;

/** Draw the steps of the frames, and the stairs of the chosen measure at the present stop. */
export function showSteps() {
  const { frames, stop, stairs } = scene;
  const steps = stepsOf(frames);
  const measures = gapsOf(frames);
  const measure = measures.find(({ id }) => id === stairs) ?? measures[0];
  if (!measure || state.chapter !== "analyse") return;
  const { id: chosen, title, between, signals, help } = measure;
  const now = steps.map(({ id }) => values(frames, chosen, id)?.[stop] ?? NaN);
  const heights = levels(now, axis(frames, chosen));
  const line = treads(heights);
  const what = (frames.signals && signals) || between;
  const heads = steps.map(
    ({ id, help, short, step, brief }) =>
      html`<button role="radio" data-stage="${id}" title="${help}" ${checked(id === state.stage)}>
        <b>${symbol(short)}</b><span class="long">${step}</span><span class="brief">${brief}</span></button>`,
  );
  const outputs = steps.map(
    ({ id }, i) =>
      html`<output data-step="${id}" role="img" aria-label="${title} after the ${steps[i].step}:
        ${asText(chosen, now[i], 2)}" class="${id === state.stage && "open"}"
        style="transform:translateY(${(heights[i] - HIGH).toFixed(1)}px)">${asText(chosen, now[i], 2)}</output>`,
  );
  $(".staircase").style.setProperty("--steps", steps.length);
  draw(
    $(".staircase"),
    html`<div class="stair"><select class="of-steps" aria-label="What the stairs show">${options(
      measures.map(({ id, title }) => [id, title]),
      chosen,
    )}</select><div class="treads heads" role="radiogroup" aria-label="Step of the head; opens its map">
      ${heads}</div></div>
    <div class="stair" data-name="${chosen}"><span class="stair-name" title="${help}">${title} <small>
      ${what}</small></span><div class="treads"><svg viewBox="0 0 ${steps.length} ${HIGH}" preserveAspectRatio="none"
      aria-hidden="true"><path class="under" d="${line}V${HIGH}H0Z"/><path class="tread" d="${line}"/></svg>
      ${outputs}</div></div>`,
  );
  $(".of-steps").value = chosen; // a visitor may have chosen one that these frames lack
}

/** Return height of each step, from the top; a missing value keeps the previous height.
 * @param {number[]} now @param {Span} span */
export function levels(now, [low, high]) {
  let y = HIGH;
  return now.map((v) => {
    if (Number.isFinite(v)) y = HIGH - 1.5 - ((v - low) / (high - low || 1)) * (HIGH - WORDS - 1.5);
    return y;
  });
}

/** Return a line of treads, one unit wide each. @param {number[]} heights */
export const treads = (heights) => heights.map((y, i) => `${i ? "V" : "M0 "}${y.toFixed(2)}H${i + 1}`).join("");
