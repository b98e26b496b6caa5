/** A pair on a map: photo and touch with the way they came, and the nodes of its tree as stars. */

import { segment, stroked } from "./canvas.js";
import { isDark } from "./palette.js";
import { SHAPES } from "./points.js";

const [SIDE, ROOT, NODE] = [9, 14, 10]; // CSS pixels from the middle of a mark
const NEAR = 15; // from a star, where it is pointed at
const GOLD = { root: "#f59e0b", node: "#fde68a" };
/** @typedef {CanvasRenderingContext2D} Context */
/** What is drawn, in CSS pixels: a missing image has no place. `trail`: earlier places, the oldest first; `guess`: images
 * whose place is one; `lit`: a node, -1 for none.
 * @typedef {{places: Record<Modality, Point>, nodes: Point[], parents: number[], trail: Record<Modality, Point[]>,
 *   guess: Partial<Record<Modality, boolean>>, lit: number}} PairMarks */

const SHAPE = /** @type {const} */ ({ vis: "circle", tac: "triangle" });
const there = (/** @type {Point | undefined} */ place) => Boolean(place && Number.isFinite(place[0]));

/** The path of a star. @param {Context} context @param {Point} place @param {number} radius */
export function star(context, [x, y], radius) {
  for (let i = 0; i < 10; i++) {
    const [angle, r] = [(i * Math.PI) / 5 - Math.PI / 2, i % 2 ? 0.45 * radius : radius];
    context.lineTo(x + r * Math.cos(angle), y + r * Math.sin(angle));
  }
  context.closePath();
}

/** The star at a place, -1 for none. @param {Point[]} nodes @param {Point} place */
export function starAt(nodes, [x, y]) {
  const far = nodes.map((node) => Math.hypot(node[0] - x, node[1] - y));
  const least = Math.min(...far);
  return least < NEAR ? far.indexOf(least) : -1;
}

/** @param {Context} context @param {PairMarks} marks */
export function pairMarks(context, { places, nodes, parents, trail, guess, lit }) {
  const [ink, page, own] = isDark() ? ["#e8eef6", "#0b1220", "#7db4ff"] : ["#0f172a", "#ffffff", "#1d4ed8"];
  context.lineJoin = context.lineCap = "round";
  const images = /** @type {Modality[]} */ (["vis", "tac"]).filter((name) => there(places[name]));
  for (const name of images) {
    const way = [...trail[name], places[name]];
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
