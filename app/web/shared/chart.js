/** Line charts: scales, axes and lines as SVG text, and dragging along the horizontal axis. */

import { each } from "./text.js";

/** @type {(v: number, span: number[]) => number} */
const share = (v, [low, high]) => (v - low) / (high - low || 1);

/** Places of values in a chart: `xs` and `ys` are the ends of its axes, `pad` what is free around them. */
export class Scale {
  constructor({ wide, high, pad, xs = [0, 1], ys = [0, 1] }) {
    this.wide = wide;
    this.high = high;
    this.left = pad.left;
    this.right = wide - pad.right;
    this.top = pad.top;
    this.base = high - pad.bottom;
    this.xs = xs;
    this.ys = ys;
  }

  x = (v) => this.left + share(v, this.xs) * (this.right - this.left);
  y = (v, ys = this.ys) => this.base - share(v, ys) * (this.base - this.top);

  /** A line through points [x, y]; one without a value ends it, and the next begins another. */
  line(points, ys = this.ys) {
    let open = false;
    return each(points, ([x, v]) => {
      const on = open;
      open = Number.isFinite(v);
      return open ? `${on ? "L" : "M"}${this.x(x).toFixed(1)} ${this.y(v, ys).toFixed(1)}` : "";
    });
  }

  /** Lines across at some values, with their figures. */
  grid(values, figure, ys = this.ys) {
    return each(
      values,
      (v) =>
        `<line class="grid" x1="${this.left}" x2="${this.right}" y1="${this.y(v, ys)}" y2="${this.y(v, ys)}"/><text x="${this.left - 6}" y="${this.y(v, ys) + 4}" text-anchor="end">${figure(v)}</text>`,
    );
  }

  /** Words under the axis: [value, word], the first from its left end, the last to its right. */
  ticks(words, below = 6) {
    const anchor = (i) => (i === 0 ? "start" : i === words.length - 1 ? "end" : "middle");
    return each(
      words,
      ([v, word], i) => `<text x="${this.x(v)}" y="${this.high - below}" text-anchor="${anchor(i)}">${word}</text>`,
    );
  }

  /** A shape from one value of the axis to another, as high as the chart. */
  band(kind, from, to) {
    const [left, right] = [from, to].map(this.x);
    return `<rect class="${kind}" x="${left}" y="${this.top}" width="${Math.max(0, right - left)}" height="${this.base - this.top}"/>`;
  }

  /** A line at a value of the axis, and the end of a line that is there already. */
  now = () => `<line class="now" y1="${this.top}" y2="${this.base}"/>`;
  mark(svg, v) {
    for (const end of ["x1", "x2"]) svg.querySelector("line.now").setAttribute(end, this.x(v));
  }

  /** The value of the axis under the pointer. */
  under({ clientX }, svg) {
    const box = svg.getBoundingClientRect();
    const at = (((clientX - box.left) / box.width) * this.wide - this.left) / (this.right - this.left);
    return this.xs[0] + Math.max(0, Math.min(1, at)) * (this.xs[1] - this.xs[0]);
  }
}

/** Call `moved(event, svg)` while a chart in a box is pressed. */
export function dragged(box, moved) {
  box.onpointerdown = (event) => {
    const svg = event.target.closest("svg");
    if (!svg) return;
    svg.setPointerCapture(event.pointerId);
    moved(event, svg);
  };
  box.onpointermove = (event) => {
    const svg = event.target.closest("svg");
    if (svg && event.buttons) moved(event, svg);
  };
}
