/** Probabilities as lines over p; orders that the head was not trained for are greyed out. */

import { dragged, Scale } from "../shared/chart.js";
import { classColour } from "../shared/palette.js";
import { View } from "../shared/view.js";
import { draw, html, percent } from "./parts.js";

const WIDE = { least: 320, most: 900 }; // CSS pixels: as wide as its place, so that letters keep their size
const H = 250;
const PAD = { left: 54, right: 86, top: 10, bottom: 30 };
const LEAST = 14; // from one label to the next
const scaleOf = (/** @type {number} */ wide) => new Scale({ wide, high: H, pad: PAD });

/** Labels at the ends of lines, moved apart so that none covers another and all stay inside. @param {number[]} ends */
export function spread(ends, low = PAD.top, high = H - PAD.bottom) {
  const gap = Math.min(LEAST, (high - low) / Math.max(1, ends.length - 1));
  const sorted = ends.map((y, k) => ({ y, k })).sort((a, b) => a.y - b.y);
  let limit = low;
  for (const end of sorted) {
    end.y = Math.max(end.y, limit);
    limit = end.y + gap;
  }
  limit = high;
  for (const end of sorted.toReversed()) {
    end.y = Math.min(end.y, limit);
    limit = end.y - gap;
  }
  return sorted.sort((a, b) => a.k - b.k).map(({ y }) => y);
}

export class Lines extends View {
  /** @type {Curves | null} */
  curves = null;
  scale = scaleOf(WIDE.least);

  /** @param {HTMLElement} box @param {(p: number) => void} onOrder */
  constructor(box, onOrder) {
    super(box);
    new ResizeObserver(() => this.curves && this.show(this.curves)).observe(box);
    dragged(box, (event, svg) => onOrder(Math.round(100 * this.scale.under(event, svg)) / 100));
  }

  /** @param {Curves} curves */
  show(curves) {
    this.curves = curves;
    const { classes, rows, learned, band, p } = curves;
    const scale = (this.scale = scaleOf(Math.max(WIDE.least, Math.min(WIDE.most, this.box.clientWidth))));
    const stops = rows.length - 1;
    const labels = spread(rows[stops].map((v) => scale.y(v)));
    const lines = classes.map((name, k) => {
      const style = classColour(k);
      const line = scale.line(rows.map((row, i) => [i / stops, row[k]]));
      return {
        line: html`<path d="${line}" style="stroke:${style}"/>`,
        name: html`<text class="name" x="${scale.right + 6}" y="${labels[k] + 4}"><tspan style="fill:${style}">
          ━ </tspan>${name}</text>`,
        dot: html`<circle r="4" cx="${scale.x(p)}" cy="${scale.y(rows[Math.round(p * stops)][k])}"
          style="fill:${style}"/>`,
      };
    });
    // outside the band is a what-if, drawn pale
    const veil = band && [scale.band("veil", 0, band[0]), scale.band("veil", band[1], 1), scale.band("band", ...band)];
    const ticks = [0, 0.25, 0.5, 0.75, 1].map((tick) => [tick, tick]);
    const mark =
      learned >= 0 &&
      learned <= 1 &&
      html`<path class="learned-at" d="M${scale.x(learned)} ${scale.top - 1}l-4 -7h8z"/>`;
    draw(
      this.box,
      scale.svg(
        "Probability of each class against p",
        scale.grid([0, 0.5, 1], percent),
        scale.ticks(ticks, 12),
        html`<text x="${(scale.left + scale.right) / 2}" y="${H - 1}" text-anchor="middle">p</text>`,
        mark,
        lines.map(({ line }) => line),
        veil,
        lines.map(({ name }) => name),
        scale.now(p),
        lines.map(({ dot }) => dot),
      ),
    );
  }
}
