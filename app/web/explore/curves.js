/** Charts against p, one for each measure. Click or drag one to move p. */

import { dragged, Scale } from "../shared/chart.js";
import { asText, axis, gapsOf, spread, values } from "../shared/measures.js";
import { span } from "../shared/order.js";
import { isLecture } from "../shared/palette.js";
import { INPUT } from "../shared/stages.js";
import { can, has, sensorOf, TABLES } from "../shared/tables.js";
import { $, change, draw, html, scene, state } from "./root.js";
import { loneDomain, whole } from "./scene.js";

const LEAST = 150; // CSS pixels; charts are drawn at the width of their box, so text keeps its size
const PAD = { left: 54, right: 10, top: 8, bottom: 24 }; // explore.css sets the slider under a chart by these
/** Draw charts in a box, as wide as it; return what draws them at the present stop.
 * @param {string} selector @param {() => number} high @param {(scale: Scale) => Html} make */
function charts(selector, high, make) {
  const box = $(selector);
  let wide = LEAST;
  let scale = new Scale({ wide, high: high(), pad: PAD });
  const show = () => {
    scale = new Scale({ wide, high: high(), pad: PAD, xs: span(scene.frames) });
    draw(box, make(scale));
  };
  dragged(box, (event, svg) => change({ p: scene.frames.orders[scene.frames.stop(scale.under(event, svg))] }));
  new ResizeObserver(([{ contentRect }]) => {
    const now = Math.max(LEAST, Math.min(900, Math.floor(contentRect.width))); // never smaller than its letters
    if (now === wide) return;
    wide = now;
    if (box.firstChild) show();
  }).observe(box);
  return show;
}

/** Return accuracy against p, above the slider. */
export const accuracy = () =>
  charts(
    ".over",
    () => {
      if (innerWidth < 820 || innerHeight <= 500) return 110;
      if (state.chapter !== "order") return 0.165 * innerHeight;
      if (isLecture()) return 0.28 * innerHeight;
      return Math.min(560, 0.18 * innerHeight + 0.5 * Math.max(0, innerHeight - 720));
    },
    (scale) => html`${TABLES.measures.filter((row) => can(row, "predictions")).map((row) => curve(row, scale))}`,
  );

/** Return all measures of features against p. */
export const features = () =>
  charts(
    ".all",
    () => 108,
    (scale) => html`${gapsOf(scene.frames).map((row) => curve(row, scale))}${DASHED}`,
  );

/** Return the line at the present p. @param {Scale} scale */
const nowOf = (scale) => scale.now(scene.frames.orders[scene.stop]);

/** Return one curve of a stage, or of a single domain if only one is shown.
 * @param {Measure} measure @param {Scale} box */
function curve(measure, box) {
  const { id: name, title, help } = measure;
  const { frames, stop } = scene;
  const { stage } = state;
  const domain = loneDomain(scene, state);
  const scale = box.of(axis(frames, name));
  const accurate = can(measure, "predictions");
  const together = !can(measure, "domain"); // only for all domains together
  const only = together ? "" : domain;
  const own = values(frames, name, stage, only);
  const known = own && (accurate ? visible(own) : own);
  const band = state.chapter !== "order" && spread(frames, name, stage, only);
  const ghost = accurate
    ? frames.orders.map(() => 1 / frames.classes.length)
    : stage !== INPUT && values(frames, name, INPUT, only);
  const of = (only && sensorOf(only)) || (together && domain ? "all domains" : accurate ? "unseen domains" : "");
  const value = own?.[stop] ?? NaN;
  const [a, b] = scale.xs;
  const ends = [a, (a + b) / 2, b].map((p, i) => [p, i === 1 ? "p" : +p.toFixed(2)]);
  const path = (/** @type {string} */ kind, /** @type {string} */ d) => html`<path class="${kind}" d="${d}"/>`;
  const drawn = scale.svg(
    `${title} against p: ${help}`,
    scale.grid(scale.ys, (v) => (accurate ? `${100 * v} %` : +v.toFixed(2))),
    scale.ticks(ends),
    trained(scale),
    nowOf(scale),
    band && path("spread", scale.area(zip(frames.orders, band.low), zip(frames.orders, band.high))),
    ghost && path("ghost", line(ghost, scale)),
    accurate && pale(scale),
    known && path("own", line(known, scale)),
    known && has(frames, "heads") && html`<g class="dots">${dots(known, scale)}</g>`,
    Number.isFinite(value) &&
      html`<circle class="now" r="4" cx="${scale.x(frames.orders[stop])}" cy="${scale.y(value)}"/>`,
  );
  return html`<figure data-name="${name}"><figcaption class="${accurate && "sr"}" title="${help}"><span>${title} <small
    class="of">${of}</small></span><output>${asText(name, value)}</output></figcaption>${drawn}</figure>`;
}

/** Return the values that may be drawn: in the chapter of the order those between which p was dragged.
 * @param {number[]} own */
function visible(own) {
  if (state.chapter !== "order") return own;
  const [from, to] = scene.dragged.get(scene.frames) ?? [1, 0];
  return own.map((v, i) => (i >= from && i <= to ? v : NaN));
}

/** Return the accuracy of another set, pale; in the chapter of the order once p was dragged over all stops.
 * @param {Scale} scale */
function pale(scale) {
  const other = state.chapter === "order" && scene.sets.find(({ name }) => scene.set && name !== scene.set)?.curve;
  if (!other || !whole(scene)) return null;
  const { orders, share, title } = other;
  const words = (/** @type {number} */ y, /** @type {string} */ text) =>
    html`<text x="${scale.x(1) - 2}" y="${y}" text-anchor="end">${text}</text>`;
  const guessing = scale.y(1 / scene.frames.classes.length) + 17;
  return html`<path class="pale" d="${scale.line(zip(orders, share))}"/>
    ${words(scale.y(Math.max(...share)) - 7, title)}${words(guessing, "chance")}`;
}

/** Return the band of orders that the head was trained for. @param {Scale} scale */
function trained(scale) {
  const [low, high] = scene.frames.fits ?? [NaN, NaN];
  const [a, b] = scale.xs;
  return high >= a && low <= b ? scale.band("band", Math.max(a, low), Math.min(b, high)) : null;
}

/** Return a line through the values that exist. Stops of coarse frames are dots.
 * @param {number[]} own @param {Scale} scale */
export function line(own, scale, frames = scene.frames) {
  const points = zip(frames.orders, own);
  if (!frames.coarse) return scale.line(points);
  return points.map(([p, v]) => `M${scale.x(p)} ${scale.y(v)}h.01`).join("");
}

/** Return a dot for each stop that has a head of its own. @param {number[]} own @param {Scale} scale */
const dots = (own, scale) =>
  zip(scene.frames.orders, own).map(
    ([p, v]) => Number.isFinite(v) && html`<circle cx="${scale.x(p)}" cy="${scale.y(v)}" r="2"/>`,
  );

/** @type {(orders: number[], all: number[]) => Point[]} */
const zip = (orders, all) => orders.map((p, i) => [p, all[i]]);
const DASHED = html`<p class="hint">Dashed line: the raw embedding; for accuracy, chance.</p>`;
