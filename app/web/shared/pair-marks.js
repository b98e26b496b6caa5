/** A pair on a map: photo and touch with the way they came, and the nodes of its tree as stars. */

import { segment, stroked } from "./canvas.js";
import { isDark } from "./palette.js";
import { SHAPES } from "./points.js";

const [SIDE, ROOT, NODE] = [9, 14, 10]; // CSS pixels from the middle of a mark
const NEAR = 15; // from a star, where it is pointed at
const GOLD = { root: "#f59e0b", node: "#fde68a" };
/** @typedef {CanvasRenderingContext2D} Context @typedef {import("./cloud.js").Cloud} Cloud */
const LEVELS = 65535; // of a position in frames
const IMAGES = /** @type {const} */ (["vis", "tac"]);

/** Return the stop of a journey at an order; -1 if it has none.
 * @param {Journey | null} journey @param {number} order */
export const journeyStop = (journey, order) => journey?.orders.findIndex((p) => Math.abs(p - order) < 1e-4) ?? -1;

/** Return where a pair and its nodes are at a stop of its journey on a map, in map units.
 * @param {Journey} journey @param {string} kind @param {number} at
 * @returns {{places: Partial<Record<Modality, Point>>, nodes: Point[]}} */
export function placesAt({ maps }, kind, at) {
  const { places, nodes } = maps[kind] ?? { places: {}, nodes: [] };
  return {
    places: Object.fromEntries(Object.entries(places).map(([name, all]) => [name, all[at]])),
    nodes: nodes[at] ?? [],
  };
}

/** Return the positions of a map with those of a pair and its nodes after them, so that all glide together.
 * @param {Positions} frame @param {ReturnType<typeof placesAt>} marks @returns {Positions} */
export function withMarks(frame, { places, nodes }) {
  const [low, high] = frame.bounds;
  const spots = [...IMAGES.map((name) => places[name] ?? [NaN, NaN]), ...nodes];
  const more = spots.flatMap((spot) => [0, 1].map((i) => ((spot[i] - low[i]) / (high[i] - low[i])) * LEVELS));
  const points = new Float32Array(frame.points.length + more.length);
  points.set(frame.points);
  points.set(more, frame.points.length);
  return { ...frame, points };
}

/** Return a position of frames in map units. @param {Positions} frame @param {number} point @returns {Point} */
export function placeIn({ points, bounds: [low, high] }, point) {
  const at = (/** @type {0 | 1} */ i) => low[i] + (points[2 * point + i] / LEVELS) * (high[i] - low[i]);
  return [at(0), at(1)];
}

/** Return the images of a journey whose class and position are guesses.
 * @param {Journey | null} journey
 * @returns {Partial<Record<Modality, boolean>>} */
export const guessesOf = (journey) =>
  Object.fromEntries(Object.entries(journey?.images ?? {}).map(([name, { guess }]) => [name, guess]));

const SHAPE = /** @type {const} */ ({ vis: "circle", tac: "triangle" });
const there = (/** @type {Point | undefined} */ place) => Boolean(place && Number.isFinite(place[0]));

/** Return the corners of a star. @param {Point} place @param {number} radius @returns {Point[]} */
export const starOf = ([x, y], radius) =>
  Array.from({ length: 10 }, (_, i) => {
    const [angle, r] = [(i * Math.PI) / 5 - Math.PI / 2, i % 2 ? 0.45 * radius : radius];
    return [x + r * Math.cos(angle), y + r * Math.sin(angle)];
  });

/** Trace the path of a star. @param {Context} context @param {Point} place @param {number} radius */
function star(context, place, radius) {
  for (const corner of starOf(place, radius)) context.lineTo(...corner);
  context.closePath();
}

/** Return the star at a place, -1 for none. @param {Point[]} nodes @param {Point} place */
export function starAt(nodes, [x, y]) {
  const far = nodes.map((node) => Math.hypot(node[0] - x, node[1] - y));
  const near = far.filter((length) => length < NEAR);
  return far.indexOf(Math.min(...near));
}

/** Draw the pair that a map has beside its points. `before`: its earlier places in map units, the oldest first; `lit`:
 * a node, -1 for none.
 * @param {Context} context @param {Cloud} cloud
 * @param {{journey: Journey | null, before: Partial<Record<Modality, Point>>[], lit?: number}} of */
export function pairMarks(context, cloud, { journey, before, lit = -1 }) {
  const [vis, tac, ...nodes] = cloud.extras();
  if (!vis) return;
  /** @type {Record<Modality, Point>} */
  const places = { vis, tac };
  const guess = guessesOf(journey);
  const parents = journey?.tree.parents ?? [];
  const [ink, page, own] = isDark() ? ["#e8eef6", "#0b1220", "#7db4ff"] : ["#0f172a", "#ffffff", "#1d4ed8"];
  context.lineJoin = context.lineCap = "round";
  const images = IMAGES.filter((name) => there(places[name]));
  for (const name of images) {
    const earlier = before.flatMap((place) => (place[name] ? [cloud.spot(/** @type {Point} */ (place[name]))] : []));
    const way = [...earlier, places[name]];
    for (let i = 1; i < way.length; i++) {
      context.globalAlpha = (0.75 * i) / way.length;
      stroked(context, () => segment(context, way[i - 1], way[i]), [3, own]);
      context.fillStyle = own;
      context.beginPath();
      SHAPES[SHAPE[name]](context, way[i - 1], 4);
      context.fill();
    }
  }
  context.globalAlpha = 1;
  nodes.forEach((node, i) => {
    const above = nodes[parents[i]];
    if (above) stroked(context, () => segment(context, above, node), [4.5, page], [1.8, ink]);
  });
  nodes.forEach((node, i) => {
    const [size, wide] = lit === i ? [1.6, 3] : [1, 1.6];
    context.fillStyle = i ? GOLD.node : GOLD.root;
    stroked(context, () => star(context, node, size * (i ? NODE : ROOT)), [wide, lit === i ? own : "#0f172a"]);
    context.fill();
  });
  if (images.length > 1) stroked(context, () => segment(context, places.vis, places.tac), [5, page], [2, own]);
  for (const name of images) {
    context.setLineDash(guess[name] ? [4, 4] : []);
    context.fillStyle = guess[name] ? page : own;
    const trace = () => SHAPES[SHAPE[name]](context, places[name], SIDE);
    stroked(context, trace, [guess[name] ? 2.5 : 5, guess[name] ? own : page]);
    context.fill();
    context.setLineDash([]);
    if (guess[name]) {
      context.font = "700 13px sans-serif";
      context.textAlign = "center";
      context.fillStyle = own;
      context.fillText("?", places[name][0], places[name][1] + 5);
    }
  }
}
