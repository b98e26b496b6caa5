/** Line charts: scales, axes and lines as SVG, and dragging along the horizontal axis. */

import { html } from "./text.js";

/** @param {number} v @param {number[]} span */
const share = (v, [low, high]) => (v - low) / (high - low || 1);

/** Places of values in a chart: `xs` and `ys` are the ends of its axes, `pad` what is free around them. */
export class Scale {
  /** @param {{wide: number, high: number, pad: Record<"left" | "right" | "top" | "bottom", number>, xs?: number[],
   *   ys?: number[]}} parts */
  constructor(parts) {
    const { wide, high, pad, xs = [0, 1], ys = [0, 1] } = (this.parts = parts);
    this.wide = wide;
    this.high = high;
    this.xs = xs;
    this.ys = ys;
    this.left = pad.left;
    this.right = wide - pad.right;
    this.top = pad.top;
    this.base = high - pad.bottom;
  }

  /** The same with another upright axis. @param {number[]} ys */
  of = (ys) => new Scale({ ...this.parts, ys });

  /** @param {number} v */
  x = (v) => this.left + share(v, this.xs) * (this.right - this.left);
  /** @param {number} v */
  y = (v) => this.base - share(v, this.ys) * (this.base - this.top);

  /** A line through points [x, y]; one without a value ends it, and the next begins another.
   * @param {number[][]} points */
  line(points) {
    let before = false;
    return points
      .map(([x, v]) => {
        const step = before ? "L" : "M";
        before = Number.isFinite(v);
        return before ? `${step}${this.x(x).toFixed(1)} ${this.y(v).toFixed(1)}` : "";
      })
      .join("");
  }

  /** The shape between two lines. @param {number[][]} above @param {number[][]} below */
  area = (above, below) => `${this.line(above)}${this.line(below.toReversed()).replace("M", "L")}Z`;

  /** A line across at a value. @param {string} kind @param {number} v */
  across = (kind, v) =>
    html`<line class="${kind}" x1="${this.left}" x2="${this.right}" y1="${this.y(v)}" y2="${this.y(v)}"/>`;

  /** Lines across at some values, with their figures. @param {number[]} values
   * @param {(v: number) => string | number} figure */
  grid(values, figure) {
    return html`${values.map(
      (v) =>
        html`${this.across("grid", v)}<text x="${this.left - 6}" y="${this.y(v) + 4}" text-anchor="end">
          ${figure(v)}</text>`,
    )}`;
  }

  /** Words under the axis: [value, word], the first from its left end, the last to its right.
   * @param {(string | number)[][]} words */
  ticks(words, below = 6) {
    /** @param {number} i */
    const anchor = (i) => (i === 0 ? "start" : i === words.length - 1 ? "end" : "middle");
    return html`${words.map(
      ([v, word], i) =>
        html`<text x="${this.x(Number(v))}" y="${this.high - below}" text-anchor="${anchor(i)}">${word}</text>`,
    )}`;
  }

  /** A shape from one value of the axis to another, as high as the chart.
   * @param {string} kind @param {number} from @param {number} to */
  band(kind, from, to) {
    const [left, right] = [from, to].map(this.x);
    return html`<rect class="${kind}" x="${left}" y="${this.top}" width="${Math.max(0, right - left)}"
      height="${this.base - this.top}"/>`;
  }

  /** A line at a value of the axis. @param {number} v */
  now = (v) => html`<line class="now" x1="${this.x(v)}" x2="${this.x(v)}" y1="${this.top}" y2="${this.base}"/>`;

  /** A drawing of this size. @param {Markup} label @param {...unknown} parts */
  svg = (label, ...parts) =>
    html`<svg class="chart" viewBox="0 0 ${this.wide} ${this.high}" role="img" aria-label="${label}">${parts}</svg>`;

  /** The value of the axis under the pointer. @param {{clientX: number}} event @param {Element} svg */
  under({ clientX }, svg) {
    const box = svg.getBoundingClientRect();
    const at = (((clientX - box.left) / box.width) * this.wide - this.left) / (this.right - this.left);
    return this.xs[0] + Math.max(0, Math.min(1, at)) * (this.xs[1] - this.xs[0]);
  }
}

/** Call `moved(event, svg)` while a chart in a box is pressed.
 * @param {Found} box @param {(event: PointerEvent, svg: SVGSVGElement) => unknown} moved */
export function dragged(box, moved) {
  box.onpointerdown = (/** @type {Found} */ event) => {
    const svg = event.target.closest("svg");
    if (!svg) return;
    svg.setPointerCapture(event.pointerId);
    moved(event, svg);
  };
  box.onpointermove = (/** @type {Found} */ event) => {
    const svg = event.target.closest("svg");
    if (svg && event.buttons) moved(event, svg);
  };
}
