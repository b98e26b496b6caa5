/** The steps of the head as a flow, with stairs of a gap or the margin; each step opens its map. */

import { asText, axis, gapsOf, MEASURES, values } from "../shared/measures.js";
import { ARROWS } from "../shared/radios.js";
import { stepsOf } from "../shared/stages.js";
import { options } from "../shared/text.js";
import { $, all, change, html, put, scene, state, take } from "./root.js";

const HIGH = 33; // CSS pixels of a row of stairs
const WORDS = 16; // of these, above the highest step, for its figure

/** What the stairs show: their axis, and the values of each step.
 * @type {{ys: Span, series: (number[] | null)[]}} */
let shown = { ys: [0, 1], series: [] };

/** A letter, with its index below it. @param {string} short */
const symbol = (short) => html`${short.replace("_p", "")}${short.endsWith("_p") && html`<sub>p</sub>`}`;

/** Lay out the steps of new frames. */
export function layOutSteps() {
  const { frames } = scene;
  const steps = stepsOf(frames);
  const measures = gapsOf(frames).map(({ name, title }) => [name, title]);
  const known = measures.some(([name]) => name === scene.stairs);
  const { stairs } = known ? scene : take({ stairs: measures[0]?.[0] ?? "" });
  const heads = steps.map(
    ({ key, explain, short, step, brief }) =>
      html`<button role="radio" data-stage="${key}" title="${explain}"><b>${symbol(short)}</b><span class="long">${step}</span><span class="brief">${brief}</span></button>`,
  );
  $(".staircase").style.setProperty("--steps", steps.length);
  put(
    $(".staircase"),
    html`<div class="stair heads"><select class="of-steps" aria-label="What the stairs show">${options(measures, stairs)}</select><div class="treads" role="radiogroup" aria-label="Step of the head; opens its map">${heads}</div></div><div class="stair row-of-stairs"></div>`,
  );
  showStairs();
}

/** Draw the stairs of the chosen measure. */
export function showStairs() {
  const { frames, stairs } = scene;
  const measure = MEASURES.find(({ name }) => name === stairs);
  if (!measure) return;
  const { title, between, help } = measure;
  const steps = stepsOf(frames);
  const what = frames.signals && stairs === "modality_gap" ? "VIS to TAC" : between;
  shown = { ys: axis(frames, stairs), series: steps.map(({ key }) => values(frames, stairs, key)) };
  const outputs = steps.map(({ key }) => html`<output data-step="${key}"></output>`);
  const box = $(".row-of-stairs");
  box.dataset.name = stairs;
  put(
    box,
    html`<span class="stair-name" title="${help}">${title} <small>${what}</small></span><div class="treads"><svg viewBox="0 0 ${steps.length} ${HIGH}" preserveAspectRatio="none" aria-hidden="true"><path class="under"/><path class="tread"/></svg>${outputs}</div>`,
  );
  markStep();
  showStop();
}

/** Mark the open step. */
export function markStep() {
  for (const button of all(".heads [role=radio]")) {
    const on = button.dataset.stage === state.stage;
    button.setAttribute("aria-checked", on);
    button.tabIndex = on ? 0 : -1;
  }
  for (const cell of all("[data-step]")) cell.classList.toggle("open", cell.dataset.step === state.stage);
}

/** Write the figures of the stop. */
export function showStop() {
  const { stairs, stop } = scene;
  const outputs = all("[data-step]");
  const now = shown.series.map((values) => values?.[stop] ?? NaN);
  const heights = levels(now, shown.ys);
  const line = treads(heights);
  outputs.forEach((output, i) => {
    output.textContent = asText(stairs, now[i], 2);
    output.style.transform = `translateY(${(heights[i] - HIGH).toFixed(1)}px)`;
  });
  $(".staircase .under")?.setAttribute("d", line && `${line}V${HIGH}H0Z`);
  $(".staircase .tread")?.setAttribute("d", line);
}

/** The arrow keys open the next step or the one before. @param {KeyboardEvent & {target: Found}} event */
export function stepByKey(event) {
  const by = ARROWS[event.key];
  if (!by || !event.target.matches("[role=radio]")) return;
  event.preventDefault();
  const keys = stepsOf(scene.frames).map(({ key }) => key);
  const stage = keys[(keys.indexOf(state.stage) + by + keys.length) % keys.length];
  change({ stage });
  $(`[data-stage="${stage}"]`).focus();
}

/** Height of each step, from the top; a missing value keeps the previous height.
 * @param {number[]} now @param {Span} span */
export function levels(now, [low, high]) {
  let y = HIGH;
  return now.map((v) => {
    if (Number.isFinite(v)) y = HIGH - 1.5 - ((v - low) / (high - low || 1)) * (HIGH - WORDS - 1.5);
    return y;
  });
}

/** A line of treads, one unit wide each. @param {number[]} heights */
export const treads = (heights) => heights.map((y, i) => `${i ? "V" : "M0 "}${y.toFixed(2)}H${i + 1}`).join("");
