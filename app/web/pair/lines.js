/** Probabilities as lines over p; orders that the head was not trained for are greyed out. */

import { classColour } from "../shared/palette.js";
import { escaped } from "../shared/text.js";

const WIDE = { least: 320, most: 900 }; // CSS pixels: as wide as its place, so that letters keep their size
const H = 250;
const PAD = { left: 48, right: 86, top: 10, bottom: 30 };
const Y = (v) => H - PAD.bottom - v * (H - PAD.top - PAD.bottom);

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

export class Lines {
  constructor(box, onOrder) {
    this.box = box;
    this.wide = WIDE.least;
    new ResizeObserver(() => this.shown && this.width() !== this.wide && this.again()).observe(box);
    const moved = (event) => {
      const frame = box.querySelector("svg").getBoundingClientRect();
      const p =
        (((event.clientX - frame.left) / frame.width) * this.wide - PAD.left) / (this.wide - PAD.left - PAD.right);
      onOrder(Math.round(100 * Math.max(0, Math.min(1, p))) / 100);
    };
    box.onpointerdown = (event) => {
      if (!box.querySelector("svg")) return;
      box.setPointerCapture(event.pointerId);
      moved(event);
    };
    box.onpointermove = (event) => event.buttons && moved(event);
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
    const labels = spread(classes.map((_, k) => Y(rows.at(-1)[k])));
    const lines = classes.map((name, k) => {
      const d = rows
        .map((row, i) => `${i ? "L" : "M"}${this.x(orders[i]).toFixed(1)} ${Y(row[k]).toFixed(1)}`)
        .join("");
      return {
        path: `<path d="${d}" style="stroke:${classColour(k)}"/>`,
        label: `<text class="name" x="${this.wide - PAD.right + 6}" y="${labels[k] + 4}"><tspan style="fill:${classColour(k)}">━ </tspan>${escaped(name)}</text>`,
      };
    });
    const dots = classes.map((_, k) => `<circle r="4" style="fill:${classColour(k)}"/>`);
    this.box.innerHTML = `<svg viewBox="0 0 ${this.wide} ${H}" role="img" aria-label="Probability of each class against p">${this.frame(learned)}${lines.map((one) => one.path).join("")}${this.veil(band)}${lines.map((one) => one.label).join("")}<line class="now" y1="${PAD.top}" y2="${H - PAD.bottom}"/>${dots.join("")}</svg>`;
  }

  /** The axes, and the learned p. */
  frame(learned) {
    const [left, right] = [PAD.left, this.wide - PAD.right];
    const grid = [0, 0.5, 1].map(
      (v) =>
        `<line class="grid" x1="${left}" x2="${right}" y1="${Y(v)}" y2="${Y(v)}"/><text x="${left - 6}" y="${Y(v) + 4}" text-anchor="end">${100 * v} %</text>`,
    );
    const stops = [0, 0.25, 0.5, 0.75, 1].map(
      (p) => `<text x="${this.x(p)}" y="${H - 12}" text-anchor="middle">${p}</text>`,
    );
    const mark =
      learned >= 0 && learned <= 1
        ? `<path class="learned-at" d="M${this.x(learned)} ${H - PAD.bottom + 1}l-4 7h8z"/>`
        : "";
    return `${grid.join("")}${stops.join("")}<text x="${(left + right) / 2}" y="${H - 1}" text-anchor="middle">p</text>${mark}`;
  }

  /** Outside the band is a what-if, drawn pale. */
  veil(band) {
    if (!band) return "";
    const [low, high] = band.map(this.x);
    const rect = (kind, from, to) =>
      `<rect class="${kind}" x="${from}" y="${PAD.top}" width="${Math.max(0, to - from)}" height="${H - PAD.top - PAD.bottom}"/>`;
    return rect("veil", this.x(0), low) + rect("veil", high, this.x(1)) + rect("band", low, high);
  }

  x = (p) => PAD.left + p * (this.wide - PAD.left - PAD.right);

  mark(stop, orders) {
    this.at = [stop, orders];
    const svg = this.box.querySelector("svg");
    if (!svg) return;
    const now = svg.querySelector(".now");
    now.setAttribute("x1", this.x(orders[stop]));
    now.setAttribute("x2", this.x(orders[stop]));
    svg.querySelectorAll("circle").forEach((dot, k) => {
      dot.setAttribute("cx", this.x(orders[stop]));
      dot.setAttribute("cy", Y(this.rows[stop][k]));
    });
  }
}
