/** Curves against p on fixed axes, with the current p marked; click or drag one to move p. */

import { dragged, Scale } from "../shared/chart.js";
import { asText, axis, MEASURES, spread, values } from "../shared/measures.js";
import { has } from "../shared/tables.js";
import { each, escaped } from "../shared/text.js";
import { View } from "../shared/view.js";

const LEAST = 150; // CSS pixels; charts are drawn at the width of their box, so text keeps its size
const PAD = { left: 54, right: 10, top: 8, bottom: 24 }; // explore.css sets the slider under a chart by these
const ENDS = [0, 1]; // of the axis, whichever stops are ready

export class Curves extends View {
  /** Charts of some measures, `high()` CSS pixels high each. */
  constructor(box, onOrder, { measures, high = () => 108 }) {
    super(box);
    /** @type {any} */
    this.frames = null;
    this.onOrder = onOrder;
    this.wanted = measures; // (frames) => names
    /** @type {any[]} */
    this.measures = [];
    this.tall = high;
    this.pale = null; // {title, orders, share}: the accuracy curve of another set
    this.hides = false; // whether a curve is drawn only as far as p was dragged
    this.wide = LEAST;
    this.scale = new Scale({ wide: LEAST, high: high(), pad: PAD });
    /** @type {any[]} */
    this.charts = [];
    this.shown = ["f_hat", ""]; // stage and lone domain
    this.stop = 0;
    dragged(box, (event, svg) => this.onOrder(this.scale.under(event, svg)));
    new ResizeObserver(() => this.frames && this.width() !== this.wide && this.again()).observe(box);
  }

  width() {
    const around = this.$("figure") ?? this.box;
    const { paddingLeft, paddingRight } = getComputedStyle(around);
    const borders = around.offsetWidth - around.clientWidth; // clientWidth itself is rounded, up as well
    const padding = (parseFloat(paddingLeft) || 0) + (parseFloat(paddingRight) || 0);
    const inside = around.getBoundingClientRect().width - borders - padding;
    return Math.max(LEAST, Math.min(900, Math.floor(inside) || LEAST)); // never drawn smaller than its letters
  }

  again() {
    this.replace(this.frames);
    this.show(this.shown[0], this.shown[1]);
    this.mark(this.stop);
  }

  /** Draw for new frames: their range of p, their axes. */
  replace(frames) {
    this.frames = frames;
    const xs = [Math.min(ENDS[0], frames.orders[0]), Math.max(ENDS[1], frames.orders.at(-1))];
    const names = this.wanted(frames);
    const known = this.measures.map(({ name }) => name).join() === names.join();
    this.measures = MEASURES.filter(({ name }) => names.includes(name));
    if (!known || !this.$("figure"))
      this.box.innerHTML = each(this.measures, figure) + (this.measures.length > 1 ? DASHED : "");
    this.wide = this.width();
    this.scale = new Scale({ wide: this.wide, high: this.tall(), pad: PAD, xs });
    this.charts = [...this.box.querySelectorAll("figure")].map((root, i) => ({ root, ...this.measures[i] }));
    for (const chart of this.charts) {
      chart.ys = axis(frames, chart.name);
      chart.root.querySelector("svg").outerHTML = this.chart(chart);
    }
    this.box.classList.toggle("what-if", has(frames, "what-if"));
  }

  chart({ name, title, help, ys }) {
    const { scale } = this;
    const [a, b] = scale.xs;
    const figure = (v) => (name === "accuracy" ? `${100 * v} %` : +v.toFixed(2));
    const ends = [a, (a + b) / 2, b].map((p, i) => [p, i === 1 ? "p" : +p.toFixed(2)]);
    return `<svg viewBox="0 0 ${scale.wide} ${scale.high}" role="img" aria-label="${title} against p: ${help}">${scale.grid(ys, figure, ys)}${scale.ticks(ends)}
      ${this.band()}${scale.now()}<path class="spread"/><path class="ghost"/>${name === "accuracy" ? this.other(ys) : ""}<path class="own"/><g class="dots"></g><circle class="now" r="4"/></svg>`;
  }

  /** The curve of another set, pale. */
  other(ys) {
    if (!this.pale) return "";
    if (this.hides && !whole(this.frames)) return "";
    const { orders, share: all, title } = this.pale;
    const { scale } = this;
    const words = (y, text) => `<text x="${scale.x(1) - 2}" y="${y}" text-anchor="end">${text}</text>`;
    const guessing = scale.y(1 / this.frames.classes.length, ys) + 17;
    return `<path class="pale" d="${scale.line(zip(orders, all), ys)}"/>${words(scale.y(Math.max(...all), ys) - 7, escaped(title))}${words(guessing, "guessing")}`;
  }

  /** The band of orders that the head was trained for. */
  band() {
    const [a, b] = this.scale.xs;
    const own = this.frames.fits;
    if (!own || own[1] < a || own[0] > b) return "";
    return this.scale.band("band", Math.max(a, own[0]), Math.min(b, own[1]));
  }

  /** A line through the values that exist. Stops of coarse frames are dots. */
  path(own, ys) {
    const points = zip(this.frames.orders, own);
    if (!this.frames.coarse) return this.scale.line(points, ys);
    return each(points, ([p, v]) => `M${this.scale.x(p)} ${this.scale.y(v, ys)}h.01`);
  }

  /** Between the lowest and the highest of several trainings. */
  area({ low, high }, ys) {
    const [there, back] = [low, high].map((all) => zip(this.frames.orders, all));
    return `${this.scale.line(there, ys)}${this.scale.line(back.reverse(), ys).replace("M", "L")}Z`;
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
      root.querySelector(".own").setAttribute("d", own ? this.path(this.known(own), ys) : "");
      root.querySelector(".ghost").setAttribute("d", ghost ? this.path(ghost, ys) : "");
      root.querySelector(".spread").setAttribute("d", band && !this.hides ? this.area(band, ys) : "");
      root.querySelector(".dots").innerHTML =
        own && has(frames, "heads")
          ? each(zip(frames.orders, this.known(own)), ([p, v]) =>
              Number.isFinite(v) ? `<circle cx="${this.scale.x(p)}" cy="${this.scale.y(v, ys)}" r="2"/>` : "",
            )
          : "";
    }
  }

  /** The values that may be drawn: of the stops between which p was dragged. */
  known(own) {
    const [from, to] = this.hides ? (this.frames.seen ?? [1, 0]) : [0, own.length];
    return own.map((v, i) => (i >= from && i <= to ? v : NaN));
  }

  /** Mark one stop on every curve and write its value. */
  mark(stop) {
    this.stop = stop;
    const [from, to] = (this.frames.seen ??= [stop, stop]);
    if (this.hides && (stop < from || stop > to)) {
      this.frames.seen = [Math.min(from, stop), Math.max(to, stop)];
      return this.again();
    }
    const p = this.frames.orders[stop];
    for (const { root, own, ys, name } of this.charts) {
      this.scale.mark(root, p);
      const dot = root.querySelector("circle.now");
      const known = own && Number.isFinite(own[stop]);
      dot.setAttribute("cx", this.scale.x(p));
      dot.setAttribute("visibility", known ? "visible" : "hidden");
      if (known) dot.setAttribute("cy", this.scale.y(own[stop], ys));
      root.querySelector("output").textContent = asText(name, known ? own[stop] : NaN);
    }
    return undefined;
  }
}

/** Whether p was dragged over all stops of these frames. */
export const whole = ({ seen, orders }) => seen?.[0] === 0 && seen[1] === orders.length - 1;

const zip = (orders, all) => orders.map((p, i) => [p, all[i]]);
const DASHED = '<p class="hint">Dashed: the raw embedding; for accuracy, guessing.</p>';
const figure = ({ name, title, help }) =>
  `<figure data-name="${name}"><figcaption title="${help}"><span>${title} <small class="of"></small></span><output></output></figcaption><svg></svg></figure>`;
