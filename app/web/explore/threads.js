/** Chapter 3: the touches of all twins on one map, a thread from a press to its twins, and what moves them. */

import { address, ask, attempt } from "../shared/api.js";
import { Cloud } from "../shared/cloud.js";
import { twinsMap as fetchMap, twins as fetchTwins } from "../shared/facts.js";
import { held } from "../shared/held.js";
import { domainColour, isDark } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { provenance } from "../shared/provenance.js";
import { PLACES, rungOf, worded } from "../shared/tables.js";
import { bytesOf } from "../shared/text.js";
import { METHODS } from "./maps.js";
import { sheet } from "./pictures.js";
import { $, change, choice, draw, fill, html, percent, scene, send, showWords, state } from "./root.js";
import { OWN_ROWS, ownHtml, splitHtml } from "./split.js";
import { chosen, READINGS } from "./touch.js";

const CHOICES = PLACES.map(({ id, title = "", help }) => ({ key: id, label: title, title: help }));
const KINDS = Object.entries(METHODS).map(([key, label]) => ({ key, label }));
const GLIDE = 700; // milliseconds
const TILE = 46; // CSS pixels of a picture on the map; less on a small one
const TOUCH = 1; // row of a sheet of pictures
const RADIUS = 1.9; // of a point, CSS pixels
/** @type {[Point, Point]} */
const BOUNDS = [
  [0, 0],
  [1, 1],
];

/** A point is 8 × press + sensor. @type {Cloud} */
export let cloud;
/** Method -> positions of each place. @type {Record<string, Uint16Array[]>} */
const places = {};
/** Return whether the page shows another set than the project's, whose bars then stand above those of the twins. */
export const isOwn = () => scene.first === "analyse" && !held;

/** Open the chapter: fetch the twins and their map, and draw them. */
export async function open() {
  const [twins, twinsMap] = await Promise.all([fetchTwins(), fetchMap()]);
  send("arrived", { twins, twinsMap });
  if (!cloud) {
    build();
    if (isOwn()) measure();
    else $(".split.own").remove();
  }
  show();
}

/** Make the map and the buttons, once. */
function build() {
  const { twins, twinsMap } = scene;
  for (const kind of /** @type {("pca" | "umap")[]} */ (["pca", "umap"]))
    places[kind] = twinsMap[kind].map((text) => new Uint16Array(bytesOf(text).buffer));
  cloud = new Cloud($(".threads"), twinsMap.presses * twins.domains.length);
  listen(cloud, {
    wanted: () => true,
    hover,
    pick,
    next: (/** @type {number} */ by) => pick(pointOf(pressShown() + by)),
    current: () => scene.twin,
  });
  cloud.painters = [thread];
}

/** Return the number of the shown press, and its point by the sensor that the first chapter learned from. */
const pressShown = () => chosen(scene.twins, state).press;
const pointOf = (/** @type {number} */ number) => {
  const { shown, domains } = scene.twins;
  return shown[(number + shown.length) % shown.length].press * domains.length;
};

/** @param {number} twin */
function hover(twin) {
  if (twin === scene.twin) return;
  send("arrived", { twin });
  cloud.paintMarks();
}

/** @param {number} point */
function pick(point) {
  const { shown, domains } = scene.twins;
  const number = shown.findIndex(({ press }) => press === Math.floor(point / domains.length));
  if (number >= 0) change({ press: String(number) });
}

/** Show one sensor alone in full colour; again, all. @param {number} domain */
export function chooseSensor(domain) {
  send("sensorChosen", domain);
  showSensors();
  showLayers();
}

/** Draw the chapter: choices, sensors, points and figures. */
export function show() {
  if (!cloud) return;
  const { twins } = scene;
  const { table, look } = chosen(twins, state);
  choice(".kinds", "map", KINDS);
  choice(".places", "rung", CHOICES);
  choice(".split.twins .segments", "reading", READINGS);
  showSensors();
  showLayers();
  glide();
  cloud.paintMarks();
  fill($(".split.twins .bars"), splitHtml(twins, table, look));
  tell();
}

/** Measure accuracy on the loaded set: in the source, in other domains, and there with pictures or labels. Draw each
 * bar when its figure arrives. */
async function measure() {
  const showKnown = () => fill($(".split.own .bars"), ownHtml(scene.known));
  showKnown();
  for (const { id: known } of OWN_ROWS) {
    const learn = (/** @type {Scene["known"][string]} */ record) => send("measured", { [known]: record });
    await attempt(
      async () => learn(await ask("known", { known })),
      (/** @type {string} */ problem) => learn({ problem }),
    );
    showKnown();
  }
}

/** Return the place that is shown. */
const placeNow = () => rungOf(state).map ?? 0;

/** Show a button for each sensor, with the share of its own twins. */
function showSensors() {
  const { twins, twinsMap, alone } = scene;
  const buttons = twins.domains.map(
    ({ sensor }, i) =>
      html`<button data-domain="${i}" aria-pressed="${String(alone === i)}">
        <i style="background:${domainColour(i)}"></i>${sensor}
        <b>${percent(twinsMap.own_twin[i][placeNow()])}</b></button>`,
  );
  draw($(".sensors"), html`${buttons}`);
}

/** Show the points of each sensor in its colour. */
function showLayers() {
  const { twins, twinsMap, alone } = scene;
  const { presses } = twinsMap;
  const { length } = twins.domains;
  cloud.layers = twins.domains.map((_, i) => ({
    style: { shape: "circle", colour: domainColour(i), radius: RADIUS, alpha: alone < 0 || alone === i ? 0.7 : 0.08 },
    at: Int32Array.from({ length: presses }, (_, n) => n * length + i),
    count: presses,
  }));
  cloud.redraw();
}

/** Let the points glide to the chosen place; on another method they are there at once. */
function glide() {
  const kind = state.map;
  const wanted = `${kind} ${placeNow()}`;
  if (wanted === scene.glided) return;
  const frame = { points: places[kind][placeNow()], bounds: BOUNDS };
  if (scene.glided.startsWith(kind)) cloud.glide(frame, GLIDE);
  else cloud.show(frame);
  send("arrived", { glided: wanted });
}

/** Draw the thread of the press under the pointer, or of the chosen one with its pictures. @type {Painter} */
function thread(context) {
  const { domains, shown } = scene.twins;
  const { length } = domains;
  const home = pointOf(pressShown());
  const point = scene.twin >= 0 ? scene.twin : home;
  const first = point - (point % length);
  const [middle, ...twins] = [point, ...Array.from({ length }, (_, i) => first + i)].map((at) => cloud.place(at));
  context.strokeStyle = isDark() ? "#e8eef6" : "#0f172a";
  context.lineWidth = 1.6;
  context.beginPath();
  for (const [x, y] of twins) {
    context.moveTo(middle[0], middle[1]);
    context.lineTo(x, y);
  }
  context.stroke();
  const pictures = first === home && sheet(address(`twins/${shown[pressShown()].sheet}`), () => cloud.paintMarks());
  twins.forEach(([x, y], i) => (pictures ? tile(context, pictures, x, y, i) : dot(context, x, y, domainColour(i))));
}

/** Draw the touch of a press by one sensor, framed in its colour.
 * @param {CanvasRenderingContext2D} context @param {HTMLImageElement} pictures @param {number} x @param {number} y
 * @param {number} domain */
function tile(context, pictures, x, y, domain) {
  const side = pictures.naturalWidth / scene.twins.domains.length;
  const size = Math.min(TILE, cloud.width / 14);
  const [left, top] = [x - size / 2, y - size / 2];
  context.fillStyle = domainColour(domain);
  context.fillRect(left - 3, top - 3, size + 6, size + 6);
  context.drawImage(pictures, domain * side, TOUCH * side, side, side, left, top, size, size);
}

/** Draw a dot with a rim.
 * @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {string} colour */
function dot(context, x, y, colour) {
  context.beginPath();
  context.arc(x, y, 6, 0, 7);
  context.fillStyle = colour;
  context.fill();
  context.stroke();
}

/** Write title, figure and remark. */
export function tell() {
  const { own_twin_mean: nearest, gap, accuracy } = scene.twinsMap;
  const at = placeNow();
  const own = isOwn();
  const share = (/** @type {number} */ v) => html`<b>${percent(v)}</b>`;
  const apart = gap[at].toFixed(2);
  const gain = `Accuracy on other sensors rises by ${Math.round(100 * (accuracy[at] - accuracy[0]))} points.`;
  const { words, brief = words, remark = "" } = rungOf(state);
  return showWords({
    title: `Where do ${own ? "the project’s simulated touches" : "the touches"} go?`,
    figure: html`${share(accuracy[at])} correct on another sensor (mean of eight training sensors).
      For ${share(nearest[at])} of presses, the nearest picture from another sensor shows the same press; the list
      below has the share of each sensor.`,
    remark: worded(remark, { apart, first: gap[0].toFixed(2), gain }),
    whence: provenance({
      head: "eight logistic regressions",
      source: "one sensor each",
      pairs: "the other seven",
      known: brief,
    }),
  });
}
