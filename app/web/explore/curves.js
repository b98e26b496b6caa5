/** Charts against p: one for each measure, or accuracy and both gaps in one. Click or drag one to move p. */

import { dragged, Scale } from "../shared/chart.js";
import { asText, axis, gapsOf, spread, values } from "../shared/measures.js";
import { isLecture } from "../shared/palette.js";
import { has, TABLES } from "../shared/tables.js";
import { $, change, html, put, scene, state } from "./root.js";
import { loneDomain, whole } from "./scene.js";

const LEAST = 150; // CSS pixels; charts are drawn at the width of their box, so text keeps its size
const PAD = { left: 54, right: 10, top: 8, bottom: 24 }; // explore.css sets the slider under a chart by these
const LINES = [
  ["accuracy", "accuracy"],
  ["modality_gap", "modality gap"],
  ["domain_gap", "domain gap"],
];
/** @typedef {{draw: () => void, mark: () => void}} Chart */

/** Charts in a box, as wide as it: `draw` makes them of the frames, `mark` shows p. Each returns what it drew of a stop.
 * @param {string} selector @param {() => number} high @param {(box: Found, scale: Scale) => (stop: number) => void} make
 * @returns {Chart} */
function charts(selector, high, make) {
  const box = $(selector);
  const wide = () => Math.max(LEAST, Math.min(900, Math.floor(box.getBoundingClientRect().width))); // never smaller than its letters
  let scale = new Scale({ wide: LEAST, high: high(), pad: PAD });
  let markAt = (/** @type {number} */ _) => {};
  const mark = () => markAt(scene.stop);
  const draw = () => {
    const { orders } = scene.frames;
    const xs = [Math.min(0, orders[0]), Math.max(1, orders[orders.length - 1])]; // whichever stops are ready
    scale = new Scale({ wide: wide(), high: high(), pad: PAD, xs });
    markAt = make(box, scale);
    mark();
  };
  dragged(box, (event, svg) => change({ p: scene.frames.orders[scene.frames.stop(scale.under(event, svg))] }));
  new ResizeObserver(() => box.firstChild && wide() !== scale.wide && draw()).observe(box);
  return { draw, mark };
}

/** A chart for each measure of the frames.
 * @param {string} selector @param {(frames: Frames) => Measure[]} measures @param {() => number} high */
const single = (selector, measures, high) =>
  charts(selector, high, (box, scale) => {
    const rows = measures(scene.frames).map((row) => curve(row, scale));
    put(box, html`${rows.map(({ figure }) => figure)}${rows.length > 1 && DASHED}`);
    const roots = [...box.querySelectorAll("figure")];
    return (stop) => roots.forEach((root, i) => markCurve(root, rows[i], stop));
  });

/** Accuracy against p, above the slider. */
export const accuracy = () =>
  single(
    ".over",
    () => TABLES.measures.filter(({ id }) => id === "accuracy"),
    () => {
      if (innerWidth < 820) return 110;
      if (state.chapter !== "order") return 0.165 * innerHeight;
      if (isLecture()) return 0.4 * innerHeight;
      return Math.min(560, 0.24 * innerHeight + 0.5 * Math.max(0, innerHeight - 720));
    },
  );

/** All measures of features against p. */
export const features = () => single(".all", gapsOf, () => 108);

/** Accuracy and both gaps in one chart, each with its value at the present stop. */
export const together = () =>
  charts(
    ".together",
    () => 112,
    (box, scale) => {
      const { frames } = scene;
      const known = LINES.map(([name]) => values(frames, name, "f_hat"));
      const key = LINES.map(([name, title]) => html`<span class="${name}">${title} <output></output></span>`);
      const lines = known.map(
        (curve, i) => curve && html`<path class="${LINES[i][0]}" d="${scale.line(zip(frames.orders, curve))}"/>`,
      );
      put(
        box,
        html`<p class="key">${key}</p>${scale.svg("Accuracy and both gaps against p", scale.grid([0, 1], String), scale.now(), lines)}`,
      );
      const outputs = box.querySelectorAll("output");
      return (stop) => {
        scale.mark(box, frames.orders[stop]);
        LINES.forEach(([name], i) => (outputs[i].textContent = asText(name, known[i]?.[stop], 2)));
      };
    },
  );

/** @typedef {{name: string, scale: Scale, values: number[] | null, figure: Html}} Curve */

/** One curve of a stage, or of a single domain if only one is shown. @param {Measure} measure @param {Scale} box
 * @returns {Curve} */
function curve({ id: name, title, help }, box) {
  const { frames } = scene;
  const { stage } = state;
  const domain = loneDomain(scene, state);
  const scale = box.of(axis(frames, name));
  const accurate = name === "accuracy";
  const together = name === "domain_gap" || name === "margin"; // only for all domains together
  const only = together ? "" : domain;
  const own = values(frames, name, stage, only);
  const known = own && (accurate ? visible(own) : own);
  const band = state.chapter !== "order" && spread(frames, name, stage, only);
  const ghost = accurate
    ? frames.orders.map(() => 1 / frames.classes.length)
    : stage !== "raw" && values(frames, name, "raw", only);
  const of = only || (together && domain ? "all domains" : accurate ? "unseen domains" : "");
  const [a, b] = scale.xs;
  const ends = [a, (a + b) / 2, b].map((p, i) => [p, i === 1 ? "p" : +p.toFixed(2)]);
  const path = (/** @type {string} */ kind, /** @type {string} */ d) => html`<path class="${kind}" d="${d}"/>`;
  const drawn = scale.svg(
    `${title} against p: ${help}`,
    scale.grid(scale.ys, (v) => (accurate ? `${100 * v} %` : +v.toFixed(2))),
    scale.ticks(ends),
    trained(scale),
    scale.now(),
    band && path("spread", area(band, scale)),
    ghost && path("ghost", line(ghost, scale)),
    accurate && pale(scale),
    known && path("own", line(known, scale)),
    known && has(frames, "heads") && html`<g class="dots">${dots(known, scale)}</g>`,
    html`<circle class="now" r="4"/>`,
  );
  const figure = html`<figure data-name="${name}"><figcaption class="${accurate && "sr"}" title="${help}"><span>${title} <small class="of">${of}</small></span><output></output></figcaption>${drawn}</figure>`;
  return { name, scale, values: own, figure };
}

/** Mark one stop on a curve and write its value. @param {Found} root @param {Curve} curve @param {number} stop */
function markCurve(root, { name, scale, values }, stop) {
  const p = scene.frames.orders[stop];
  const value = values?.[stop] ?? NaN;
  const known = Number.isFinite(value);
  const dot = root.querySelector("circle.now");
  scale.mark(root, p);
  dot.setAttribute("cx", scale.x(p));
  dot.setAttribute("cy", known ? scale.y(value) : 0);
  dot.setAttribute("visibility", known ? "visible" : "hidden");
  root.querySelector("output").textContent = asText(name, value);
}

/** The values that may be drawn: in the chapter of the order those between which p was dragged. @param {number[]} own */
function visible(own) {
  if (state.chapter !== "order") return own;
  const [from, to] = scene.dragged.get(scene.frames) ?? [1, 0];
  return own.map((v, i) => (i >= from && i <= to ? v : NaN));
}

/** The accuracy of another set, pale; in the chapter of the order once p was dragged over all stops.
 * @param {Scale} scale */
function pale(scale) {
  const other = state.chapter === "order" && scene.sets.find(({ name }) => scene.set && name !== scene.set)?.curve;
  if (!other || !whole(scene)) return null;
  const { orders, share, title } = other;
  const words = (/** @type {number} */ y, /** @type {string} */ text) =>
    html`<text x="${scale.x(1) - 2}" y="${y}" text-anchor="end">${text}</text>`;
  const guessing = scale.y(1 / scene.frames.classes.length) + 17;
  return html`<path class="pale" d="${scale.line(zip(orders, share))}"/>${words(scale.y(Math.max(...share)) - 7, title)}${words(guessing, "guessing")}`;
}

/** The band of orders that the head was trained for. @param {Scale} scale */
function trained(scale) {
  const [low, high] = scene.frames.fits ?? [NaN, NaN];
  const [a, b] = scale.xs;
  return high >= a && low <= b ? scale.band("band", Math.max(a, low), Math.min(b, high)) : null;
}

/** A line through the values that exist. Stops of coarse frames are dots.
 * @param {number[]} own @param {Scale} scale */
export function line(own, scale, frames = scene.frames) {
  const points = zip(frames.orders, own);
  if (!frames.coarse) return scale.line(points);
  return points.map(([p, v]) => `M${scale.x(p)} ${scale.y(v)}h.01`).join("");
}

/** Between the lowest and the highest of several trainings.
 * @param {{low: number[], high: number[]}} band @param {Scale} scale */
function area({ low, high }, scale) {
  const [there, back] = [low, high].map((all) => zip(scene.frames.orders, all));
  return `${scale.line(there)}${scale.line(back.reverse()).replace("M", "L")}Z`;
}

/** A dot for each stop that has a head of its own. @param {number[]} own @param {Scale} scale */
const dots = (own, scale) =>
  zip(scene.frames.orders, own).map(
    ([p, v]) => Number.isFinite(v) && html`<circle cx="${scale.x(p)}" cy="${scale.y(v)}" r="2"/>`,
  );

/** @type {(orders: number[], all: number[]) => Point[]} */
const zip = (orders, all) => orders.map((p, i) => [p, all[i]]);
const DASHED = html`<p class="hint">Dashed: the raw embedding; for accuracy, guessing.</p>`;
