/** What the second chapter draws above the points: both gaps between means, and the chosen pair with its tree. */

import { segment, stroked } from "../shared/canvas.js";
import { ink } from "../shared/marks.js";
import { groupsOf } from "../shared/means.js";
import { pairMarks } from "../shared/pair-marks.js";
import { colouring } from "../shared/palette.js";
import { SHAPES } from "../shared/points.js";
import { OUTPUT } from "../shared/stages.js";
import { scene, state } from "./root.js";

const LEVELS = 65535;
const IMAGES = /** @type {const} */ (["vis", "tac"]);

/** A thick line from the mean of photos to that of touches, and thin ones from the source's mean to each domain's.
 * @param {Wanted} shown @returns {Painter} */
export const gapLines = (shown) => (context, cloud) => {
  const { frames } = scene;
  const [page, modality, domain] = ["--ov-card", "--ov-source", "--ov-right"].map((name) => ink(cloud.box, name));
  const groups = groupsOf(frames, cloud, shown, colouring(frames, "domain"));
  const source = groups.find(({ name }) => name === frames.source) ?? groups[0];
  context.lineCap = "round";
  for (const { both } of groups)
    if (both && source.both && both !== source.both)
      stroked(context, () => segment(context, /** @type {Point} */ (source.both), both), [5, page], [2.4, domain]);
  for (const { both, colour } of groups) {
    if (!both) continue;
    context.fillStyle = colour;
    stroked(context, () => SHAPES.circle(context, both, both === source.both ? 6.5 : 4.5), [4, page], [1.6, domain]);
    context.fill();
  }
  const [{ vis, tac }] = groupsOf(frames, cloud, shown, { ...colouring(frames, "domain"), values: undefined });
  if (!vis || !tac) return;
  stroked(context, () => segment(context, vis, tac), [11, page], [7, modality]);
  context.fillStyle = modality;
  for (const [shape, place] of /** @type {const} */ ([
    ["circle", vis],
    ["triangle", tac],
  ])) {
    stroked(context, () => SHAPES[shape](context, place, 7), [4, page]);
    context.fill();
  }
};

/** The stop of the chosen pair's journey at a stop of the frames; -1 if it has none. */
export const journeyStop = (stop = scene.stop) =>
  scene.chosen.journey?.orders.findIndex((p) => Math.abs(p - scene.frames.orders[stop]) < 1e-4) ?? -1;

/** Where the chosen pair and its nodes are at a stop, in map units. @param {string} kind @param {number} stop
 * @returns {{places: Partial<Record<Modality, Point>>, nodes: Point[]}} */
function marksAt(kind, stop) {
  const { frames, chosen } = scene;
  const { journey, row } = chosen;
  const at = journeyStop(stop);
  const drawn = state.stage === OUTPUT && at >= 0 ? journey?.maps[kind] : null;
  if (drawn) {
    const places = Object.fromEntries(Object.entries(drawn.places).map(([name, all]) => [name, all[at]]));
    return { places, nodes: drawn.nodes[at] };
  }
  if (row < 0) return { places: {}, nodes: [] };
  const { points, bounds } = frames.positions(kind, state.stage, stop);
  const place = (/** @type {number} */ point) =>
    /** @type {Point} */ (
      [0, 1].map((i) => bounds[0][i] + (points[2 * point + i] / LEVELS) * (bounds[1][i] - bounds[0][i]))
    );
  return { places: { vis: place(row), tac: place(row + frames.pairs) }, nodes: [] };
}

/** The positions of a map with those of the pair and its nodes after them, so that all glide together.
 * @param {Positions} frame @param {string} kind @returns {Positions} */
export function withPair(frame, kind) {
  const { places, nodes } = marksAt(kind, scene.stop);
  const [low, high] = frame.bounds;
  const spots = [...IMAGES.map((name) => places[name] ?? [NaN, NaN]), ...nodes];
  const more = spots.flatMap((spot) => [0, 1].map((i) => ((spot[i] - low[i]) / (high[i] - low[i])) * LEVELS));
  const points = new Float32Array(frame.points.length + more.length);
  points.set(frame.points);
  points.set(more, frame.points.length);
  return { ...frame, points };
}

/** The chosen pair and its tree, with its places at the last stops. @param {(stage: string) => string} kindOf
 * @returns {Painter} */
export const pairOnMap = (kindOf) => (context, cloud) => {
  const { chosen, trail, node } = scene;
  const [vis, tac, ...nodes] = cloud.extras();
  if (!vis) return;
  const kind = kindOf(state.stage);
  const before = trail.map((stop) => marksAt(kind, stop).places);
  const way = (/** @type {Modality} */ name) =>
    before.flatMap((places) => (places[name] ? [cloud.spot(places[name])] : []));
  pairMarks(context, {
    places: { vis, tac },
    nodes,
    parents: chosen.journey?.tree.parents ?? [],
    trail: { vis: way("vis"), tac: way("tac") },
    guess: guesses(),
    lit: node,
  });
};

/** The images of the chosen pair whose place is a guess: unlike all training images, on a map that is not linear. */
export const guesses = () =>
  Object.fromEntries(Object.entries(scene.chosen.journey?.images ?? {}).map(([name, { guess }]) => [name, guess]));
