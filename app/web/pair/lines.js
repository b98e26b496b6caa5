/** Probabilities as lines over p; orders that the head was not trained for are greyed out. */

import { dragged, Scale } from "../shared/chart.js";
import { classColour } from "../shared/palette.js";
import { each, escaped } from "../shared/text.js";
import { View } from "../shared/view.js";

const WIDE = { least: 320, most: 900 }; // CSS pixels: as wide as its place, so that letters keep their size
const H = 250;
const PAD = { left: 48, right: 86, top: 10, bottom: 30 };

/** Labels at the ends of lines, moved apart so that none covers another and all stay inside. */
export function spread(ends, low = PAD.top, high = H - PAD.bottom, least = 14) {
  const gap = Math.min(least, (high - low) / Math.max(1, ends.length - 1));
  const sorted = ends.map((y, k) => ({ y, k })).sort((a, b) => a.y - b.y);
  let limit = low;
  for (const end of sorted) {
    end.y = Math.max(end.y, limit);
    limit = end.y + gap;
  }
  limit = high;
  for (const end of [...sorted].reverse()) {
    end.y = Math.min(end.y, limit);
    limit = end.y - gap;
  }
  const places = new Array(ends.length);
  for (const { y, k } of sorted) places[k] = y;
  return places;
}

export class Lines extends View {
  constructor(box, onOrder) {
    super(box);
    this.wide = WIDE.least;
    this.scale = new Scale({ wide: WIDE.least, high: H, pad: PAD });
    /** @type {any} */
    this.shown = null; // what show had last
    /** @type {any} */
    this.at = null; // what mark had last
    this.rows = [];
    new ResizeObserver(() => this.shown && this.width() !== this.wide && this.again()).observe(box);
    dragged(box, (event, svg) => onOrder(Math.round(100 * this.scale.under(event, svg)) / 100));
  }

  width() {
    return Math.max(WIDE.least, Math.min(WIDE.most, this.box.clientWidth || WIDE.least));
  }

  /** Draw again for another width. */
  again() {
    this.show(...this.shown);
    if (this.at) this.mark(...this.at);
  }

  /** rows: (P, K) probabilities at the stops `orders`, 0 to 1; band: [low, high] trained for. */
  show(classes, orders, rows, learned, band) {
    this.shown = [classes, orders, rows, learned, band];
    this.rows = rows;
    this.wide = this.width();
    const scale = (this.scale = new Scale({ wide: this.wide, high: H, pad: PAD }));
    const labels = spread(rows.at(-1).map((v) => scale.y(v)));
    const ink = (k) => classColour(k);
    const paths = each(
      classes,
      (_, k) => `<path d="${scale.line(rows.map((row, i) => [orders[i], row[k]]))}" style="stroke:${ink(k)}"/>`,
    );
    const names = each(
      classes,
      (name, k) =>
        `<text class="name" x="${scale.right + 6}" y="${labels[k] + 4}"><tspan style="fill:${ink(k)}">━ </tspan>${escaped(name)}</text>`,
    );
    const dots = each(classes, (_, k) => `<circle r="4" style="fill:${ink(k)}"/>`);
    this.box.innerHTML = `<svg viewBox="0 0 ${this.wide} ${H}" role="img" aria-label="Probability of each class against p">${this.frame(learned)}${paths}${this.veil(band)}${names}${scale.now()}${dots}</svg>`;
  }

  /** The axes, and the learned p. */
  frame(learned) {
    const { scale } = this;
    const stops = [0, 0.25, 0.5, 0.75, 1].map((p) => [p, p]);
    const mark =
      learned >= 0 && learned <= 1
        ? `<path class="learned-at" d="M${scale.x(learned)} ${scale.base + 1}l-4 7h8z"/>`
        : "";
    return `${scale.grid([0, 0.5, 1], (v) => `${100 * v} %`)}${scale.ticks(stops, 12)}<text x="${(scale.left + scale.right) / 2}" y="${H - 1}" text-anchor="middle">p</text>${mark}`;
  }

  /** Outside the band is a what-if, drawn pale. */
  veil(band) {
    if (!band) return "";
    const { scale } = this;
    return `${scale.band("veil", 0, band[0])}${scale.band("veil", band[1], 1)}${scale.band("band", band[0], band[1])}`;
  }

  mark(stop, orders) {
    this.at = [stop, orders];
    if (!this.shown) return;
    this.scale.mark(this.box, orders[stop]);
    this.box.querySelectorAll("circle").forEach((dot, k) => {
      dot.setAttribute("cx", this.scale.x(orders[stop]));
      dot.setAttribute("cy", this.scale.y(this.rows[stop][k]));
    });
  }
}
