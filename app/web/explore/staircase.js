/** The steps of the head as a flow, with stairs of a gap or the margin; each step opens its map. */

import { asText, axis, gapsOf, values } from "../shared/measures.js";
import { ARROWS } from "../shared/radios.js";
import { stepsOf } from "../shared/stages.js";
import { $, all, change, html, put, scene, state, take } from "./root.js";

const HIGH = 33; // CSS pixels of a row of stairs
const WORDS = 16; // of these, above the highest step, for its figure

/** What the stairs of each measure show: the values of each step, and the elements.
 * @type {{name: string, ys: Span, series: (number[] | null)[], paths: Found[], outputs: Found[]}[]} */
let parts = [];

/** A letter, with its index below it. @param {string} short */
const symbol = (short) => html`${short.replace("_p", "")}${short.endsWith("_p") && html`<sub>p</sub>`}`;

/** Lay out the steps of new frames. */
export function layOutSteps() {
  const { frames } = scene;
  const steps = stepsOf(frames);
  const measures = gapsOf(frames);
  if (!measures.some(({ name }) => name === scene.stairs)) take({ stairs: measures[0]?.name ?? "" });
  $(".staircase").style.setProperty("--steps", steps.length);
  const heads = steps.map(
    ({ key, explain, short, step, brief }) =>
      html`<button type="button" role="radio" data-stage="${key}" title="${explain}"><b>${symbol(short)}</b><span class="long">${step}</span><span class="brief">${brief}</span></button>`,
  );
  const rows = measures.map(({ name, title, between, help }) => {
    const what = frames.signals && name === "modality_gap" ? "VIS to TAC" : between;
    const outputs = steps.map(({ key }) => html`<output data-step="${key}"></output>`);
    return html`<div class="stair" data-name="${name}"><span class="stair-name" title="${help}">${title} <small>${what}</small></span><div class="treads"><svg viewBox="0 0 ${steps.length} ${HIGH}" preserveAspectRatio="none" aria-hidden="true"><path class="under"/><path class="tread"/></svg>${outputs}</div></div>`;
  });
  const options = measures.map(({ name, title }) => html`<option value="${name}">${title}</option>`);
  put(
    $(".staircase"),
    html`<div class="stair heads"><select class="of-steps" aria-label="What the stairs show">${options}</select><div class="treads" role="radiogroup" aria-label="Step of the head; opens its map">${heads}</div></div>${rows}`,
  );
  parts = measures.map(({ name }) => ({
    name,
    ys: axis(frames, name),
    series: steps.map(({ key }) => values(frames, name, key)),
    paths: [...all(`.stair[data-name=${name}] path`)],
    outputs: [...all(`.stair[data-name=${name}] output`)],
  }));
  $(".of-steps").value = scene.stairs;
  choose();
}

/** Mark the open step, and show the stairs of the chosen measure. */
export function choose() {
  for (const stair of all(".stair[data-name]")) stair.hidden = stair.dataset.name !== scene.stairs;
  for (const button of all(".heads [role=radio]")) {
    const on = button.dataset.stage === state.stage;
    button.setAttribute("aria-checked", on);
    button.tabIndex = on ? 0 : -1;
  }
  for (const cell of all("[data-step]")) cell.classList.toggle("open", cell.dataset.step === state.stage);
}

/** Write the figures of the stop. */
export function showStop() {
  for (const { name, ys, series, paths, outputs } of parts) {
    const now = series.map((values) => values?.[scene.stop] ?? NaN);
    const heights = levels(now, ys);
    const line = stairs(heights);
    paths[0].setAttribute("d", line && `${line}V${HIGH}H0Z`);
    paths[1].setAttribute("d", line);
    now.forEach((v, i) => {
      outputs[i].textContent = asText(name, v, 2);
      outputs[i].style.transform = `translateY(${(heights[i] - HIGH).toFixed(1)}px)`;
    });
  }
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
export const stairs = (heights) => heights.map((y, i) => `${i ? "V" : "M0 "}${y.toFixed(2)}H${i + 1}`).join("");
