/** Curves against p on fixed axes, with the current p marked; click or drag one to move p. */

import { asText, axis, MEASURES, spread, values } from "../shared/measures.js";
import { escaped } from "../shared/text.js";

const LEAST = 150; // CSS pixels; charts are drawn at the width of their box, so text keeps its size
const PAD = { left: 54, right: 10, top: 8, bottom: 24 }; // explore.css sets the slider under a chart by these
const ENDS = [0, 1]; // of the axis, whichever stops are ready
/** @type {(v: number, span: number[]) => number} */
const share = (v, [lo, hi]) => (v - lo) / (hi - lo || 1);

export class Curves {
  /** Charts of some measures, `high()` CSS pixels high each. */
  constructor(box, onOrder, { measures, high = () => 108 }) {
    this.box = box;
    this.onOrder = onOrder;
    this.measures = MEASURES.filter(({ name }) => measures.includes(name));
    this.tall = high;
    this.high = high();
    this.pale = null; // {title, orders, share}: the accuracy curve of another set
    this.wide = LEAST;
    new ResizeObserver(() => this.frames && this.width() !== this.wide && this.again()).observe(box);
  }

  width() {
    const around = this.box.querySelector("figure") ?? this.box;
    const { paddingLeft, paddingRight } = getComputedStyle(around);
    const borders = around.offsetWidth - around.clientWidth; // clientWidth itself is rounded, up as well
    const padding = (parseFloat(paddingLeft) || 0) + (parseFloat(paddingRight) || 0);
    const inside = around.getBoundingClientRect().width - borders - padding;
    return Math.max(LEAST, Math.min(900, Math.floor(inside) || LEAST)); // never drawn smaller than its letters
  }

  again() {
    this.replace(this.frames);
    this.show(...this.shown);
    this.mark(this.stop);
  }

  x = (p) => PAD.left + share(p, this.span) * (this.wide - PAD.left - PAD.right);
  y = (v, ys) => this.high - PAD.bottom - share(v, ys) * (this.high - PAD.top - PAD.bottom);

  /** Draw for new frames: their range of p, their axes. */
  replace(frames) {
    this.frames = frames;
    this.span = [Math.min(ENDS[0], frames.orders[0]), Math.max(ENDS[1], frames.orders.at(-1))];
    if (!this.box.querySelector("figure"))
      this.box.innerHTML = this.measures.map(figure).join("") + (this.measures.length > 1 ? DASHED : "");
    this.wide = this.width();
    this.high = this.tall();
    /** @type {any[]} */
    this.charts = [...this.box.querySelectorAll("figure")].map((root, i) => ({ root, ...this.measures[i] }));
    for (const chart of this.charts) {
      chart.ys = axis(frames, chart.name);
      chart.root.querySelector("svg").outerHTML = this.chart(chart);
      this.listen(chart.root.querySelector("svg"));
    }
    this.box.classList.toggle("what-if", frames.kind === "moved");
  }

  chart({ name, title, help, ys }) {
    const [a, b] = this.span;
    const H = this.high;
    const right = this.wide - PAD.right;
    const tick = (v) => (name === "accuracy" ? `${100 * v} %` : +v.toFixed(2));
    const grid = ys.map(
      (v) =>
        `<text x="${PAD.left - 6}" y="${this.y(v, ys) + 4}" text-anchor="end">${tick(v)}</text><line class="grid" x1="${PAD.left}" x2="${right}" y1="${this.y(v, ys)}" y2="${this.y(v, ys)}"/>`,
    );
    const ends = [a, (a + b) / 2, b].map(
      (p, i) =>
        `<text x="${this.x(p)}" y="${H - 6}" text-anchor="${["start", "middle", "end"][i]}">${i === 1 ? "p" : +p.toFixed(2)}</text>`,
    );
    return `<svg viewBox="0 0 ${this.wide} ${H}" role="img" aria-label="${title} against p: ${help}">${grid.join("")}${ends.join("")}
      ${this.band()}<line class="now" y1="${PAD.top}" y2="${H - PAD.bottom}"/><path class="spread"/><path class="ghost"/>${name === "accuracy" ? this.other(ys) : ""}<path class="own"/><g class="dots"></g><circle class="now" r="4"/></svg>`;
  }

  /** The curve of another set, pale. */
  other(ys) {
    if (!this.pale) return "";
    const { orders, share: all, title } = this.pale;
    const line = all.map((v, i) => `${i ? "L" : "M"}${this.x(orders[i]).toFixed(1)} ${this.y(v, ys).toFixed(1)}`);
    const low = this.y(1 / this.frames.classes.length, ys);
    return `<path class="pale" d="${line.join("")}"/><text x="${this.x(1) - 2}" y="${this.y(Math.max(...all), ys) - 7}" text-anchor="end">${escaped(title)}</text><text x="${this.x(1) - 2}" y="${low + 17}" text-anchor="end">guessing</text>`;
  }

  /** The band of orders that the head was trained for. */
  band() {
    const [a, b] = this.span;
    const own = this.frames.fits;
    if (!own || own[1] < a || own[0] > b) return "";
    const [left, right] = [Math.max(a, own[0]), Math.min(b, own[1])].map(this.x);
    return `<rect class="band" x="${left}" width="${right - left}" y="${PAD.top}" height="${this.high - PAD.top - PAD.bottom}"/>`;
  }

  /** Drag on a chart to move p. */
  listen(svg) {
    const moved = (event) => {
      const box = svg.getBoundingClientRect();
      const at = (((event.clientX - box.left) / box.width) * this.wide - PAD.left) / (this.wide - PAD.left - PAD.right);
      const [a, b] = this.span;
      this.onOrder(a + Math.max(0, Math.min(1, at)) * (b - a));
    };
    svg.addEventListener("pointerdown", (event) => {
      svg.setPointerCapture(event.pointerId);
      moved(event);
    });
    svg.addEventListener("pointermove", (event) => event.buttons && moved(event));
  }

  /** A line through the values that exist; a missing one starts a new line. Stops of coarse frames are dots. */
  path(own, ys) {
    const { orders, coarse } = this.frames;
    if (coarse) return own.map((v, i) => `M${this.x(orders[i])} ${this.y(v, ys)}h.01`).join("");
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
                Number.isFinite(v) ? `<circle cx="${this.x(frames.orders[i])}" cy="${this.y(v, ys)}" r="2"/>` : "",
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
