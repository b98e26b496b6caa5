/** The place of the open pair on a small map of F̂. */

import { ask, attempt } from "../shared/api.js";
import { Cloud } from "../shared/cloud.js";
import { shownBy } from "../shared/filters.js";
import { orderText } from "../shared/frames.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames, pairLine } from "../shared/marks.js";
import { isDark } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { OUTPUT } from "../shared/stages.js";
import { change, state, watch } from "../shared/store.js";
import { IMAGES } from "./parts.js";

/** Returns what shows a pair at an order. @param {HTMLElement} panel @param {Frames} frames */
export function pairMap(panel, frames) {
  const [box, note] = /** @type {NodeListOf<HTMLElement>} */ (panel.querySelectorAll(".still, .where-note"));
  /** @type {Replies["place"] | null} */
  let placed = null;
  let asking = new AbortController();
  const cloud = new Cloud(box, 2 * frames.pairs);
  const kind = () => (frames.kinds(OUTPUT).includes(state.map) ? state.map : frames.kinds(OUTPUT)[0]);
  const shown = shownBy(frames);
  listen(cloud, {
    wanted: shown,
    pick: (/** @type {number} */ point) => {
      const pin = point % frames.pairs;
      if (point >= 0) change({ pin, vis: `row:${pin}`, tac: `row:${pin}` });
    },
  });
  cloud.painters = [axes(() => axisNames(kind())), (context) => placed && paint(context, cloud, placed.points)];

  /** @param {number | null} [order] */
  function points(order) {
    const stop = frames.stop(order ?? frames.meta.head?.learned_order ?? 0.5);
    cloud.layers = layersOf(frames, stop, shown, () => false, 0.34);
    cloud.show(frames.positions(kind(), OUTPUT, stop));
  }
  watch(["colour"], () => points(state.p));
  points(state.p); // a canvas without a drawing is black

  /** @param {Pair} pair @param {number | null} [order] */
  return (pair, order) => {
    points(order);
    asking.abort();
    asking = new AbortController();
    attempt(async () => {
      placed = await ask("place", { ...pair, order, map: kind() }, asking.signal);
      const how = placed.exact ? "exact" : "estimated from its nearest neighbours";
      note.textContent = `Pale points: all pairs at p = ${orderText(placed.order)}. The place of this pair is ${how}. Click a point to open its pair.`;
      cloud.paintMarks();
    }, note);
  };
}

/** @param {CanvasRenderingContext2D} context @param {Cloud} cloud @param {Replies["place"]["points"]} points */
function paint(context, cloud, points) {
  const { scale, middle, ox, oy } = cloud.transform();
  /** Pixels of a position in map units. @param {Point} place @returns {Point} */
  const at = ([x, y]) => [ox + scale * (x - middle.x), oy - scale * (y - middle.y)];
  const places = IMAGES.map((name) => points[name] && at(points[name]));
  pairLine(context, cloud, places, isDark() ? "#38bdf8" : "#1e293b");
}
