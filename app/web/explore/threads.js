/** Chapter 2: the touches of all twins on one map, a thread from a press to its twins, and what moves them. */

import { address, ask, attempt } from "../shared/api.js";
import { Cloud } from "../shared/cloud.js";
import { twins, twinsMap } from "../shared/facts.js";
import { held } from "../shared/held.js";
import { domainColour, isDark, onTheme } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { provenance } from "../shared/provenance.js";
import { radios } from "../shared/radios.js";
import { awaited } from "../shared/ready.js";
import { change, state } from "../shared/store.js";
import { bytesOf, each, escaped, fill, percent } from "../shared/text.js";
import { onClick, press } from "../shared/view.js";
import { OWN_ROWS, ownHtml, splitHtml } from "./split.js";
import { chosen, READINGS } from "./touch.js";

const PLACES = [
  { key: "0", label: "As they come" },
  { key: "1", label: "Mean moved", title: "Each sensor’s mean becomes the mean of all" },
  { key: "2", label: "Mean and spread", title: "Each feature’s spread becomes that of all, too" },
];
const KNOWN = ["nothing", "each sensor’s mean", "each sensor’s mean and spread"];
const GLIDE = 700; // milliseconds
const TILE = 46; // CSS pixels of a picture on the map; less on a small one
const TOUCH = 1; // row of a sheet of pictures
const RADIUS = 1.9; // of a point, CSS pixels

/** Positions between two places: `share` 0 is the first, 1 the second. */
export const between = (from, to, share) => from.map((v, i) => v + share * (to[i] - v));

const eased = (share) => share * share * (3 - 2 * share);
const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Threads {
  /** @type {any} */
  twins = null;
  /** @type {any} */
  map = null;
  /** @type {any} */
  cloud = null;
  /** @type {any} method -> positions of each place */
  places = {};
  hovered = -1; // a point: 8 × press + sensor
  alone = -1; // the only sensor that is shown in full colour
  moving = 0;
  arrived = (_) => {}; // of a glide that has ended
  /** @type {any} */
  ends = null; // as in `tell`
  ofCurves = "";
  shownAt = ""; // the place and method that the map shows
  markPlace = () => {};
  markReading = () => {};

  /** own: whether the page shows another set than the project's, whose bars then stand above those of the twins. */
  constructor($, own) {
    this.$ = $;
    this.own = own && !held;
    if (!this.own) $(".split.own").remove();
    this.sheet = new Image();
    this.sheet.onload = () => this.cloud.paintMarks();
  }

  async open() {
    [this.twins, this.map] = await Promise.all([twins(), twinsMap()]);
    if (!this.cloud) {
      this.build();
      if (this.own) this.measure();
    }
    this.show();
  }

  build() {
    const { domains } = this.twins;
    const count = this.map.presses * domains.length;
    this.places = Object.fromEntries(
      ["pca", "umap"].map((kind) => [kind, this.map[kind].map((all) => new Uint16Array(bytesOf(all).buffer))]),
    );
    const cloud = (this.cloud = new Cloud(this.$(".threads"), count));
    listen(cloud, {
      wanted: () => true,
      hover: (point) => this.hover(point),
      pick: (point) => this.pick(point),
      next: (by) => this.pick(this.pointOf(this.chosen() + by)),
      current: () => this.hovered,
    });
    cloud.painters = [(context) => this.thread(context)];
    onTheme(() => cloud.redraw());
    this.markPlace = radios(
      this.$(".places"),
      PLACES,
      () => state.rung,
      (rung) => change({ rung }),
    );
    this.markReading = radios(
      this.$(".split.twins .segments"),
      READINGS,
      () => state.reading,
      (reading) => change({ reading }),
    );
    onClick(this.$(".sensors"), {
      button: ({ dataset }) => {
        this.alone = this.alone === +dataset.domain ? -1 : +dataset.domain;
        this.showSensors();
        this.showLayers();
      },
    });
  }

  /** The number of the shown press, and its point by the sensor that the first chapter learned from. */
  chosen = () => chosen(this.twins).press;
  pointOf(shown) {
    const { length } = this.twins.shown;
    return this.twins.shown[(shown + length) % length].press * this.twins.domains.length;
  }

  hover(point) {
    if (point === this.hovered) return;
    this.hovered = point;
    this.cloud.paintMarks();
  }

  pick(point) {
    const shown = this.twins.shown.findIndex((one) => one.press === Math.floor(point / this.twins.domains.length));
    if (shown >= 0) change({ press: String(shown) });
  }

  show() {
    if (!this.cloud) return;
    this.markPlace();
    this.$(".explore").dataset.rung = state.rung;
    this.showSensors();
    this.showLayers();
    this.glide();
    this.sheet.src = address(`twins/${this.twins.shown[this.chosen()].sheet}`);
    this.cloud.paintMarks();
    this.showSplit();
    this.tell();
  }

  /** Bars of the page's own set: at home, away, and away with pictures or labels. */
  async measure() {
    const found = {};
    const show = () => fill(this.$(".split.own .bars"), ownHtml(found));
    show();
    for (const known of Object.keys(OWN_ROWS)) {
      await attempt(
        async () => (found[known] = await ask("known", { known })),
        (problem) => (found[known] = { problem }),
      );
      show();
    }
  }

  showSplit() {
    const { table, dots } = chosen(this.twins);
    this.markReading();
    fill(this.$(".split.twins .bars"), splitHtml(this.twins, table, dots));
  }

  /** The place that the figures are of; the order p moves the points of another map. */
  place = () => (state.rung === "p" ? 0 : Number(state.rung));

  showSensors() {
    const at = this.place();
    fill(
      this.$(".sensors"),
      each(
        this.twins.domains,
        ({ sensor }, i) =>
          `<button type="button" data-domain="${i}" aria-pressed="${this.alone === i}"><i style="background:${domainColour(i)}"></i>${escaped(sensor)}<b>${percent(this.map.own_twin[i][at])}</b></button>`,
      ),
    );
    for (const button of this.$(".sensors").children) press(button, this.alone === +button.dataset.domain);
  }

  showLayers() {
    const { domains } = this.twins;
    const { presses } = this.map;
    const layer = (i) => ({
      style: {
        shape: "circle",
        colour: domainColour(i),
        radius: RADIUS,
        alpha: this.alone < 0 || this.alone === i ? 0.7 : 0.08,
      },
      at: Int32Array.from({ length: presses }, (_, n) => n * domains.length + i),
      count: presses,
    });
    this.cloud.layers = domains.map((_, i) => layer(i));
    this.cloud.redraw();
  }

  /** Let the points glide to the chosen place; with reduced motion, or on another method, they are there at once. */
  glide() {
    const kind = state.map;
    const wanted = `${kind} ${this.place()}`;
    if (wanted === this.shownAt) return;
    const to = this.places[kind][this.place()];
    const again = this.shownAt.startsWith(kind) && !calm() && this.$(".threads").checkVisibility();
    const from = again ? Float32Array.from(this.cloud.frame.points) : to;
    this.shownAt = wanted;
    cancelAnimationFrame(this.moving);
    const begun = performance.now();
    const step = (now) => {
      const share = again ? Math.min(1, Math.max(0, (now - begun) / GLIDE)) : 1;
      this.draw(share < 1 ? between(from, to, eased(share)) : to);
      if (share < 1) this.moving = requestAnimationFrame(step);
      else this.arrived(0);
    };
    this.arrived(0);
    awaited(new Promise((done) => (this.arrived = done)));
    step(begun);
  }

  draw(points) {
    this.cloud.show({
      points,
      bounds: [
        [0, 0],
        [1, 1],
      ],
    });
  }

  /** Draw the thread of the press under the pointer, or of the chosen one with its pictures. */
  thread(context) {
    const { cloud } = this;
    const { length } = this.twins.domains;
    const point = this.hovered >= 0 ? this.hovered : this.pointOf(this.chosen());
    const first = point - (point % length);
    const middle = cloud.place(point);
    const places = Array.from({ length }, (_, i) => cloud.place(first + i));
    context.strokeStyle = isDark() ? "#e8eef6" : "#0f172a";
    context.lineWidth = 1.6;
    context.beginPath();
    for (const [x, y] of places) {
      context.moveTo(...middle);
      context.lineTo(x, y);
    }
    context.stroke();
    const pictured = first === this.pointOf(this.chosen()) && this.sheet.complete && this.sheet.naturalWidth;
    places.forEach((place, i) => (pictured ? this.tile(context, place, i) : dot(context, place, domainColour(i))));
  }

  tile(context, [x, y], domain) {
    const side = this.sheet.naturalWidth / this.twins.domains.length;
    const tile = Math.min(TILE, this.cloud.box.clientWidth / 14);
    const [left, top] = [x - tile / 2, y - tile / 2];
    context.fillStyle = domainColour(domain);
    context.fillRect(left - 3, top - 3, tile + 6, tile + 6);
    context.drawImage(this.sheet, domain * side, TOUCH * side, side, side, left, top, tile, tile);
  }

  /** Write title, figure and remark; for where the order is what moves: `ends` of accuracy over p, and whence it is. */
  tell(ends = this.ends, ofCurves = this.ofCurves) {
    Object.assign(this, { ends, ofCurves });
    const at = this.place();
    const { own_twin_mean: nearest, gap, accuracy } = this.map;
    const b = (text) => `<b>${text}</b>`;
    const figure =
      state.rung === "p"
        ? ends
          ? `Accuracy stays between ${b(percent(ends.low))} and ${b(percent(ends.high))}, at every p.`
          : ""
        : `${b(percent(accuracy[at]))} right on another sensor. ${b(percent(nearest[at]))} lie nearest to their own twin; by sensor:`;
    const apart = (k) => gap[k].toFixed(2);
    const gain = (k) => `The heads gain ${Math.round(100 * (accuracy[k] - accuracy[0]))} points.`;
    const remark = {
      0: `One press is threaded. Sensors lie ${apart(0)} apart.`,
      1: `The offset is gone: sensors lie ${apart(1)} apart, not ${apart(0)}. ${gain(1)}`,
      2: `Sensors shift <i>and stretch</i> features; both are undone. ${gain(2)}`,
      p: this.own
        ? "p moves the points and both gaps of this set, with the weights of the loaded head."
        : "p moves the points and both gaps of 2,160 other pairs; each stop has heads trained at that p.",
    }[state.rung];
    const whence = provenance({
      head: "eight logistic regressions",
      source: "one sensor each",
      pairs: "the seven others’ twins",
      known: KNOWN[at],
    });
    const whose = this.own ? "the project’s simulated touches" : "the touches";
    const words = { title: `Where do ${whose} go?`, figure, whence: state.rung === "p" ? ofCurves : whence, remark };
    for (const [name, html] of Object.entries(words)) fill(this.$(`.stage .${name}`), html);
  }
}

function dot(context, [x, y], colour) {
  context.beginPath();
  context.arc(x, y, 6, 0, 7);
  context.fillStyle = colour;
  context.fill();
  context.stroke();
}
