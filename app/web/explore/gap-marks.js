/** What the second chapter draws above the points: both gaps between means, and the chosen pair with its tree. */

import { segment, stroked } from "../shared/canvas.js";
import { ink } from "../shared/marks.js";
import { groupsOf } from "../shared/means.js";
import { journeyStop, pairMarks, placeIn, placesAt, withMarks } from "../shared/pair-marks.js";
import { colouring } from "../shared/palette.js";
import { SHAPES } from "../shared/points.js";
import { OUTPUT } from "../shared/stages.js";
import { scene, state } from "./root.js";

/** Draw a thick line from the mean of photos to that of touches, and thin ones from the source's mean to each domain's.
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

/** Return where the chosen pair and its nodes are at a stop, in map units. @param {string} kind @param {number} stop */
function marksAt(kind, stop) {
  const { frames, chosen } = scene;
  const { journey, row } = chosen;
  const at = journeyStop(journey, frames.orders[stop]);
  if (journey?.maps[kind] && state.stage === OUTPUT && at >= 0) return placesAt(journey, kind, at);
  if (row < 0) return { places: {}, nodes: [] };
  const frame = frames.positions(kind, state.stage, stop);
  if (!frame) return { places: {}, nodes: [] };
  return { places: { vis: placeIn(frame, row), tac: placeIn(frame, row + frames.pairs) }, nodes: [] };
}

/** Return the positions of a map with the chosen pair and its nodes. @param {Positions} frame @param {string} kind */
export const withPair = (frame, kind) => withMarks(frame, marksAt(kind, scene.stop));

/** Draw the chosen pair and its tree, with its positions at the last stops.
 * @param {(stage: string) => string} kindOf
 * @returns {Painter} */
export const pairOnMap = (kindOf) => (context, cloud) => {
  const { chosen, trail, node } = scene;
  const kind = kindOf(state.stage);
  const before = trail.map((stop) => marksAt(kind, stop).places);
  pairMarks(context, cloud, { journey: chosen.journey, before, lit: node });
};
