/** Gap against accuracy: a dot for each p and step. A small gap is not a good head. */

import { axis, values } from "../shared/measures.js";
import { featuresOf, stepsOf } from "../shared/stages.js";

const HIGH = 150;
const PAD = { left: 40, right: 14, top: 22, bottom: 34 };
const LETTER = 15; // CSS pixels between the names of two steps
const GAPS = { modality_gap: "modality gap", domain_gap: "domain gap" };

export class Balance {
  /** `gap()` names the gap on the x-axis. */
  constructor(box, gap) {
    this.box = box;
    this.gap = gap;
    this.wide = 300;
    new ResizeObserver(() => this.frames && Math.abs(this.width() - this.wide) > 4 && this.again()).observe(
      box,
    );
  }

  width() {
    return Math.max(240, Math.min(460, this.box.clientWidth || 300));
  }

  again() {
    this.replace(this.frames);
    this.show(this.stop);
  }

  x = (v) =>
    PAD.left + ((v - this.xs[0]) / (this.xs[1] - this.xs[0] || 1)) * (this.wide - PAD.left - PAD.right);
  y = (v) =>
    HIGH - PAD.bottom - ((v - this.ys[0]) / (this.ys[1] - this.ys[0] || 1)) * (HIGH - PAD.top - PAD.bottom);

  /** Draw the dots of new frames or another gap. */
  replace(frames) {
    this.frames = frames;
    this.wide = this.width();
    const right = values(frames, "accuracy", "f_hat");
    this.right = right;
    if (!right?.some(Number.isFinite)) {
      this.steps = [];
      this.box.innerHTML =
        '<p class="hint">These frames have no accuracy on unseen domains, so gap and accuracy cannot be compared.</p>';
      return;
    }
    this.steps = stepsOf(frames)
      .filter(({ key }) => key !== "projection")
      .map((step) => ({ ...step, own: values(frames, this.gap(), featuresOf(step.key)) }))
      .filter(({ own }) => own);
    this.xs = axis(frames, this.gap());
    this.ys = bounds(right, 1 / frames.classes.length);
    this.box.innerHTML = `<svg viewBox="0 0 ${this.wide} ${HIGH}" role="img" aria-label="Unseen accuracy against ${GAPS[this.gap()]}: a dot for each p and step">${this.axes()}${this.dots()}<path class="walk"/>${this.steps.map(({ colour, short }) => `<g class="at"><circle r="5" style="fill:${colour}"/><text dy="-8" text-anchor="middle">${short.replace("_p", "ₚ")}</text></g>`).join("")}</svg>`;
    this.marks = [...this.box.querySelectorAll(".at")];
  }

  axes() {
    const { wide } = this;
    const bottom = HIGH - PAD.bottom;
    const rows = this.ys.map(
      (v) =>
        `<line class="grid" x1="${PAD.left}" x2="${wide - PAD.right}" y1="${this.y(v)}" y2="${this.y(v)}"/><text x="${PAD.left - 5}" y="${this.y(v) + 4}" text-anchor="end">${Math.round(100 * v)}%</text>`,
    );
    const ends = this.xs.map(
      (v, i) =>
        `<text x="${this.x(v)}" y="${bottom + 15}" text-anchor="${i ? "end" : "start"}">${+v.toFixed(2)}</text>`,
    );
    const level = this.y(1 / this.frames.classes.length);
    return `${rows.join("")}${ends.join("")}<line class="chance" x1="${PAD.left}" x2="${wide - PAD.right}" y1="${level}" y2="${level}"/><text x="${wide - PAD.right}" y="${level - 4}" text-anchor="end">guessing</text>
      <text x="${(PAD.left + wide - PAD.right) / 2}" y="${HIGH - 5}" text-anchor="middle">${GAPS[this.gap()]} →</text>`;
  }

  dots() {
    return this.steps
      .map(({ own, colour }) => {
        const circles = own.map((v, i) =>
          Number.isFinite(v) && Number.isFinite(this.right[i])
            ? `M${this.x(v).toFixed(1)} ${this.y(this.right[i]).toFixed(1)}h.01`
            : "",
        );
        return `<path class="cloud" style="stroke:${colour}" d="${circles.join("")}"/>`;
      })
      .join("");
  }

  /** Mark the steps of one stop and connect them in order. */
  show(stop) {
    this.stop = stop;
    if (!this.steps.length) return;
    const y = this.y(this.right[stop]);
    const places = this.steps.map(({ own }) => (Number.isFinite(own[stop]) ? this.x(own[stop]) : NaN));
    const letters = apart(places, LETTER);
    this.marks.forEach((mark, i) => {
      const seen = Number.isFinite(places[i]) && Number.isFinite(y);
      mark.setAttribute("visibility", seen ? "visible" : "hidden");
      if (!seen) return;
      mark.setAttribute("transform", `translate(${places[i].toFixed(1)} ${y.toFixed(1)})`);
      mark.querySelector("text").setAttribute("x", (letters[i] - places[i]).toFixed(1));
    });
    const line = places.filter(Number.isFinite).map((x) => `${x.toFixed(1)} ${y.toFixed(1)}`);
    this.box
      .querySelector(".walk")
      .setAttribute("d", Number.isFinite(y) && line.length > 1 ? `M${line.join("L")}` : "");
  }
}

/** Move places apart so that neighbours have at least this distance; together they stay in the middle.
 * @param {number[]} places @param {number} least */
export function apart(places, least) {
  const order = places.map((_, i) => i).filter((i) => Number.isFinite(places[i]));
  order.sort((a, b) => places[a] - places[b]);
  const found = [...places];
  let group = [];
  const middle = () => {
    const off = group.reduce((sum, i) => sum + found[i] - places[i], 0) / (group.length || 1);
    for (const i of group) found[i] -= off;
  };
  for (const i of order) {
    const last = group.at(-1);
    if (last !== undefined && places[i] - found[last] >= least) {
      middle();
      group = [];
    } else if (last !== undefined) found[i] = found[last] + least;
    group.push(i);
  }
  middle();
  return found;
}

/** Round bounds around all shares and the chance level. */
function bounds(shares, chance) {
  const known = [...shares.filter(Number.isFinite), chance];
  return [
    Math.max(0, Math.floor(10 * Math.min(...known) - 0.2) / 10),
    Math.min(1, Math.ceil(10 * Math.max(...known) + 0.2) / 10),
  ];
}
