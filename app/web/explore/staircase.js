/** The steps of the head as a flow, with stairs of a gap or the margin; each step opens its map. */

import { asText, axis, gapsOf, values } from "../shared/measures.js";
import { ARROWS } from "../shared/radios.js";
import { STAGES, stepsOf } from "../shared/stages.js";
import { each, escaped } from "../shared/text.js";
import { onClick, View } from "../shared/view.js";

const HIGH = 33; // CSS pixels of a row of stairs
const WORDS = 16; // of these, above the highest step, for its figure
const symbol = (short) => short.replace("_p", "<sub>p</sub>");

export class Staircase extends View {
  /** `chosen()` is the open step; `onChoose(key)` opens another. */
  constructor(box, chosen, onChoose) {
    super(box);
    this.chosen = chosen;
    this.onChoose = onChoose;
    this.row = ""; // the measure shown; the first one until another is chosen
    this.steps = STAGES;
    /** @type {any[]} */
    this.parts = [];
    onClick(box, { "[data-stage]": ({ dataset }) => onChoose(dataset.stage) });
    box.onkeydown = (event) => this.key(event);
  }

  /** Lay out the steps of new frames. */
  replace(frames) {
    this.steps = stepsOf(frames);
    const measures = gapsOf(frames);
    if (!measures.some(({ name }) => name === this.row)) this.row = measures[0]?.name ?? "";
    this.box.style.setProperty("--steps", this.steps.length);
    const heads = this.steps.map(
      (s) =>
        `<button type="button" role="radio" data-stage="${s.key}" title="${escaped(s.explain)}"><b>${symbol(s.short)}</b><span class="long">${s.step}</span><span class="brief">${s.brief}</span></button>`,
    );
    const rows = measures.map(
      ({ name, title, between, help }) =>
        `<div class="stair" data-name="${name}"><span class="stair-name" title="${help}">${title} <small>${frames.signals && name === "modality_gap" ? "VIS to TAC" : between}</small></span><div class="treads"><svg viewBox="0 0 ${this.steps.length} ${HIGH}" preserveAspectRatio="none" aria-hidden="true"><path class="under"/><path class="tread"/></svg>${each(this.steps, (s) => `<output data-step="${s.key}"></output>`)}</div></div>`,
    );
    const options = measures.map(({ name, title }) => `<option value="${name}">${title}</option>`);
    this.box.innerHTML = `<div class="stair heads"><select class="of-steps" aria-label="What the stairs show">${options.join("")}</select><div class="treads" role="radiogroup" aria-label="Step of the head; opens its map">${heads.join("")}</div></div>${rows.join("")}`;
    const select = this.$("select");
    select.value = this.row;
    select.onchange = () => this.choose((this.row = select.value));
    this.parts = measures.map(({ name }) => {
      const root = this.$(`[data-name="${name}"]`);
      return {
        name,
        ys: axis(frames, name),
        series: this.steps.map((s) => values(frames, name, s.key)),
        paths: root.querySelectorAll("path"),
        outputs: root.querySelectorAll("output"),
      };
    });
    this.choose();
  }

  /** Mark the open step, and show the stairs of one measure. */
  choose(row = this.row) {
    for (const stair of this.box.querySelectorAll("[data-name]")) stair.hidden = stair.dataset.name !== row;
    for (const button of this.box.querySelectorAll("[role=radio]")) {
      const on = button.dataset.stage === this.chosen();
      button.setAttribute("aria-checked", on);
      button.tabIndex = on ? 0 : -1;
    }
    for (const cell of this.box.querySelectorAll("[data-step]"))
      cell.classList.toggle("open", cell.dataset.step === this.chosen());
  }

  /** Write the figures of one stop. */
  show(stop) {
    for (const { name, ys, series, paths, outputs } of this.parts) {
      const now = series.map((own) => own?.[stop]);
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

  key(event) {
    const by = ARROWS[event.key];
    if (!by || !event.target.matches("[role=radio]")) return;
    event.preventDefault();
    const at = this.steps.findIndex(({ key }) => key === this.chosen());
    const { key } = this.steps[(at + by + this.steps.length) % this.steps.length];
    this.onChoose(key);
    this.$(`[role=radio][data-stage="${key}"]`).focus();
  }
}

/** Height of each step, from the top; a missing value keeps the previous height.
 * @param {number[]} now @param {number[]} span */
export function levels(now, [low, high]) {
  let y = HIGH;
  return now.map((v) => {
    if (Number.isFinite(v)) y = HIGH - 1.5 - ((v - low) / (high - low || 1)) * (HIGH - WORDS - 1.5);
    return y;
  });
}

/** A line of treads, one unit wide each. */
export const stairs = (heights) => each(heights, (y, i) => `${i ? "V" : "M0 "}${y.toFixed(2)}H${i + 1}`);
