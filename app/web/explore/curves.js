/** Curves against p on fixed axes, with the current p marked; click or drag one to move p. */

import { asText, axis, MEASURES, spread, values } from "../shared/measures.js";

const H = 108;
const LEAST = 150; // CSS pixels; charts are drawn at the width of their box, so text keeps its size
const PAD = { left: 38, right: 10, top: 8, bottom: 22 };
const CLOSE = 0.03; // a head works about this far from its learned p
/** @type {(v: number, span: number[]) => number} */
const share = (v, [lo, hi]) => (v - lo) / (hi - lo || 1);

/** The orders that the head of the frames was trained for: [from, to], or null for all of them. */
export function home(frames) {
  if (frames.kind !== "moved" || !Number.isFinite(frames.learned)) return null;
  return [frames.learned - CLOSE, frames.learned + CLOSE];
}

export class Curves {
  constructor(box, onOrder) {
    this.box = box;
    this.onOrder = onOrder;
    this.wide = LEAST;
    new ResizeObserver(() => this.frames && this.width() !== this.wide && this.again()).observe(box);
  }

  width() {
    return Math.max(
      LEAST,
      Math.min(420, (this.box.querySelector("figure") ?? this.box).clientWidth - 20 || LEAST),
    );
  }

  again() {
    this.replace(this.frames);
    this.show(...this.shown);
    this.mark(this.stop);
  }

  x = (p) => PAD.left + share(p, this.span) * (this.wide - PAD.left - PAD.right);
  y = (v, ys) => H - PAD.bottom - share(v, ys) * (H - PAD.top - PAD.bottom);

  /** Draw for new frames: their range of p, their axes. */
  replace(frames) {
    this.frames = frames;
    this.span = [frames.orders[0], frames.orders.at(-1)];
    if (!this.box.querySelector("figure")) this.box.innerHTML = MEASURES.map(figure).join("") + DASHED;
    this.wide = this.width();
    /** @type {any[]} */
    this.charts = [...this.box.querySelectorAll("figure")].map((root, i) => ({ root, ...MEASURES[i] }));
    for (const chart of this.charts) {
      chart.ys = axis(frames, chart.name);
      chart.root.querySelector("svg").outerHTML = this.chart(chart);
      this.listen(chart.root.querySelector("svg"));
    }
    this.box.classList.toggle("what-if", frames.kind === "moved");
  }

  chart({ title, help, ys }) {
    const [a, b] = this.span;
    const right = this.wide - PAD.right;
    const grid = ys.map(
      (v) =>
        `<text x="${PAD.left - 6}" y="${this.y(v, ys) + 4}" text-anchor="end">${+v.toFixed(2)}</text><line class="grid" x1="${PAD.left}" x2="${right}" y1="${this.y(v, ys)}" y2="${this.y(v, ys)}"/>`,
    );
    const ends = [a, (a + b) / 2, b].map(
      (p, i) =>
        `<text x="${this.x(p)}" y="${H - 6}" text-anchor="${["start", "middle", "end"][i]}">${i === 1 ? "p" : +p.toFixed(2)}</text>`,
    );
    return `<svg viewBox="0 0 ${this.wide} ${H}" role="img" aria-label="${title} against p: ${help}">${grid.join("")}${ends.join("")}
      ${this.band()}<path class="spread"/><path class="ghost"/><path class="own"/><g class="dots"></g><line class="now" y1="${PAD.top}" y2="${H - PAD.bottom}"/><circle class="now" r="4"/></svg>`;
  }

  /** The band of orders that the head was trained for. */
  band() {
    const [a, b] = this.span;
    const own = home(this.frames);
    if (!own || own[1] < a || own[0] > b) return "";
    const [left, right] = [Math.max(a, own[0]), Math.min(b, own[1])].map(this.x);
    return `<rect class="band" x="${left}" width="${right - left}" y="${PAD.top}" height="${H - PAD.top - PAD.bottom}"/>`;
  }

  /** Drag on a chart to move p. */
  listen(svg) {
    const moved = (event) => {
      const box = svg.getBoundingClientRect();
      const at =
        (((event.clientX - box.left) / box.width) * this.wide - PAD.left) /
        (this.wide - PAD.left - PAD.right);
      const [a, b] = this.span;
      this.onOrder(a + Math.max(0, Math.min(1, at)) * (b - a));
    };
    svg.addEventListener("pointerdown", (event) => {
      svg.setPointerCapture(event.pointerId);
      moved(event);
    });
    svg.addEventListener("pointermove", (event) => event.buttons && moved(event));
  }

  /** A line through the values that exist; a missing one starts a new line. */
  path(own, ys) {
    const { orders } = this.frames;
    return own
      .map((v, i) =>
        Number.isFinite(v)
          ? `${i && Number.isFinite(own[i - 1]) ? "L" : "M"}${this.x(orders[i]).toFixed(1)} ${this.y(v, ys).toFixed(1)}`
          : "",
      )
      .join("");
  }

  /** Between the lowest and the highest of several trainings. */
  area({ low, high }, ys) {
    const { orders } = this.frames;
    const point = (v, i) => `${this.x(orders[i]).toFixed(1)} ${this.y(v, ys).toFixed(1)}`;
    return `M${low.map(point).join("L")}L${high.map(point).reverse().join("L")}Z`;
  }

  /** Draw the curves of a stage, or of a single domain if only one is shown. */
  show(stage, domain = "") {
    this.shown = [stage, domain];
    const { frames } = this;
    for (const chart of this.charts) {
      const { root, name, ys } = chart;
      const whole = name === "domain_gap" || name === "margin"; // only for all domains together
      const only = whole ? "" : domain;
      const own = (chart.own = values(frames, name, stage, only));
      const ghost =
        name === "accuracy"
          ? frames.orders.map(() => 1 / frames.classes.length)
          : stage !== "raw" && values(frames, name, "raw", only);
      const band = spread(frames, name, stage, only);
      root.querySelector(".of").textContent =
        only || (whole && domain ? "all domains" : name === "accuracy" ? "unseen domains" : "");
      root.querySelector(".own").setAttribute("d", own ? this.path(own, ys) : "");
      root.querySelector(".ghost").setAttribute("d", ghost ? this.path(ghost, ys) : "");
      root.querySelector(".spread").setAttribute("d", band ? this.area(band, ys) : "");
      root.querySelector(".dots").innerHTML =
        own && frames.kind === "retrained"
          ? own
              .map((v, i) =>
                Number.isFinite(v)
                  ? `<circle cx="${this.x(frames.orders[i])}" cy="${this.y(v, ys)}" r="2"/>`
                  : "",
              )
              .join("")
          : "";
    }
  }

  /** Mark one stop on every curve and write its value. */
  mark(stop) {
    this.stop = stop;
    const x = this.x(this.frames.orders[stop]);
    for (const { root, own, ys, name } of this.charts) {
      const [line, dot] = root.querySelectorAll(".now");
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
      dot.setAttribute("cx", x);
      const known = own && Number.isFinite(own[stop]);
      dot.setAttribute("visibility", known ? "visible" : "hidden");
      if (known) dot.setAttribute("cy", this.y(own[stop], ys));
      root.querySelector("output").textContent = asText(name, known ? own[stop] : NaN);
    }
  }
}

const DASHED = '<p class="hint">Dashed: the raw embedding; for accuracy, guessing.</p>';
const figure = ({ name, title, help }) =>
  `<figure data-name="${name}"><figcaption title="${help}"><span>${title} <small class="of"></small></span><output></output></figcaption><svg></svg></figure>`;
