/** Probabilities as bars, and as lines over p with the current p marked. */

import { classColour } from "./palette.js";
import { escaped, percent } from "./text.js";

const WIDE = { least: 320, most: 900 }; // CSS pixels: as wide as its place, so that letters keep their size
const H = 250;
const PAD = { left: 40, right: 86, top: 10, bottom: 30 };
const Y = (v) => H - PAD.bottom - v * (H - PAD.top - PAD.bottom);
const VOICES = { vis: "VIS", tac: "TAC", both: "both" };

/** One row a class: what VIS, TAC and both give it. */
export function bars(classes, at) {
  const voices = Object.keys(VOICES).filter((voice) => at[voice]);
  const best = at.both.indexOf(Math.max(...at.both));
  return `<table class="bar-table"><thead><tr><th scope="col">Class</th>${voices.map((v) => `<th scope="col"><span class="sign ${v}"></span>${VOICES[v]}</th>`).join("")}</tr></thead><tbody>
    ${classes.map((name, k) => `<tr class="${k === best ? "best" : ""}"><th scope="row"><i style="background:${classColour(k)}"></i>${escaped(name)}</th>${voices.map((v) =>
      `<td data-voice="${v}"><span class="bar ${v}" style="--share:${at[v][k]}"></span><span class="share">${percent(at[v][k], 1)}</span></td>`).join("")}</tr>`).join("")}</tbody></table>`;
}

/** Labels at the ends of lines, moved apart so that none covers another. */
function spread(ends) {
  const sorted = ends.map((y, k) => ({ y, k })).sort((a, b) => a.y - b.y);
  sorted.forEach((end, i) => { if (i) end.y = Math.max(end.y, sorted[i - 1].y + 14); });
  const over = Math.max(0, (sorted.at(-1)?.y ?? 0) - (H - PAD.bottom));
  return sorted.reduce((out, { y, k }) => { out[k] = y - over; return out; }, []);
}

export class Lines {
  constructor(box, onOrder) {
    this.box = box;
    this.wide = WIDE.least;
    new ResizeObserver(() => this.shown && this.width() !== this.wide && this.again()).observe(box);
    const moved = (event) => {
      const frame = box.querySelector("svg").getBoundingClientRect();
      const p = ((event.clientX - frame.left) / frame.width * this.wide - PAD.left) / (this.wide - PAD.left - PAD.right);
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

  /** Draw the same for another width. */
  again() {
    this.show(...this.shown);
    if (this.at) this.mark(...this.at);
  }

  /** rows: (P, K) probabilities at the stops `orders`, 0 to 1. */
  show(classes, orders, rows, learned) {
    this.shown = [classes, orders, rows, learned];
    this.rows = rows;
    const W = (this.wide = this.width());
    const X = this.x;
    const grid = [0, 0.5, 1].map((v) => `<line class="grid" x1="${PAD.left}" x2="${W - PAD.right}" y1="${Y(v)}" y2="${Y(v)}"/><text x="${PAD.left - 6}" y="${Y(v) + 4}" text-anchor="end">${100 * v} %</text>`);
    const stops = [0, 0.25, 0.5, 0.75, 1].map((p) => `<text x="${X(p)}" y="${H - 12}" text-anchor="middle">${p}</text>`);
    const labels = spread(classes.map((_, k) => Y(rows.at(-1)[k])));
    const lines = classes.map((name, k) => {
      const d = rows.map((row, i) => `${i ? "L" : "M"}${X(orders[i]).toFixed(1)} ${Y(row[k]).toFixed(1)}`).join("");
      return `<path d="${d}" style="stroke:${classColour(k)}"/><text class="name" x="${W - PAD.right + 6}" y="${labels[k] + 4}"><tspan style="fill:${classColour(k)}">━ </tspan>${escaped(name)}</text>`;
    });
    const mark = learned >= 0 && learned <= 1 ? `<path class="learned-at" d="M${X(learned)} ${H - PAD.bottom + 1}l-4 7h8z"/>` : "";
    this.box.innerHTML = `<svg viewBox="0 0 ${W} ${H}" role="img" aria-label="Probability of each class against p">${grid.join("")}${stops.join("")}<text x="${(PAD.left + W - PAD.right) / 2}" y="${H - 1}" text-anchor="middle">p</text>${mark}${lines.join("")}<line class="now" y1="${PAD.top}" y2="${H - PAD.bottom}"/>${classes.map((_, k) => `<circle r="4" style="fill:${classColour(k)}"/>`).join("")}</svg>`;
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
