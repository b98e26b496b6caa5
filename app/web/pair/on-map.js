/** The place of the open pair on a small map of F̂. */

import { ask, attempt } from "../shared/api.js";
import { Cloud } from "../shared/cloud.js";
import { shownBy } from "../shared/filters.js";
import { orderText } from "../shared/frames.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames } from "../shared/marks.js";
import { isDark, onTheme, TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { change, state, watch } from "../shared/store.js";

const STAGE = "f_hat";

/** Returns show(pair, order). */
export function pairMap(panel, frames) {
  const box = panel.querySelector(".still");
  const note = panel.querySelector(".where-note");
  /** @type {any} */
  let placed = null;
  let asking = new AbortController();
  const cloud = new Cloud(box, 2 * frames.pairs);
  const kind = () => (frames.kinds(STAGE).includes(state.map) ? state.map : frames.kinds(STAGE)[0]);
  const shown = shownBy(frames);
  listen(cloud, {
    wanted: shown,
    pick: (point) =>
      point >= 0 &&
      change({ pin: point % frames.pairs, vis: `row:${point % frames.pairs}`, tac: `row:${point % frames.pairs}` }),
  });
  cloud.painters = [axes(() => axisNames(kind())), (context) => placed && paint(context, cloud, placed)];

  function points(order) {
    const stop = frames.stop(order ?? frames.meta.head?.learned_order ?? 0.5);
    cloud.layers = layersOf(frames, stop, shown, () => false, 0.34);
    cloud.show(frames.positions(kind(), STAGE, stop));
  }
  onTheme(() => cloud.redraw());
  watch(["colour"], () => points(state.p));
  points(state.p); // a canvas without a drawing is black

  return (pair, order) => {
    points(order);
    asking.abort();
    asking = new AbortController();
    attempt(async () => {
      placed = await ask("place", { ...pair, order, stage: STAGE, map: kind() }, asking.signal);
      note.textContent = `Pale: all pairs at p = ${orderText(placed.order)}. ${placed.exact ? "Places are exact." : "Places are estimated between the nearest neighbours."} Click a point to choose its pair.`;
      cloud.paintMarks();
    }, note);
  };
}

/** CSS pixels of a position in map units.
 * @returns {[number, number]} */
function at(cloud, [x, y]) {
  const { scale, middle, ox, oy } = cloud.transform();
  return [(ox + scale * (x - middle.x)) / cloud.ratio, (oy - scale * (y - middle.y)) / cloud.ratio];
}

function paint(context, cloud, { points }) {
  const ink = isDark() ? "#f8fafc" : "#0f172a";
  const paper = isDark() ? "#0b1220" : "#ffffff";
  const [vis, tac] = ["vis", "tac"].map((name) => points[name] && at(cloud, points[name]));
  if (vis && tac) {
    for (const [width, colour] of [
      [6, paper],
      [2.4, ink],
    ]) {
      context.beginPath();
      context.moveTo(...vis);
      context.lineTo(...tac);
      context.lineWidth = width;
      context.strokeStyle = colour;
      context.stroke();
    }
  }
  if (vis) disc(context, vis, VIS_COLOUR, "V");
  if (tac) disc(context, tac, TAC_COLOUR, "T");
}

function disc(context, [x, y], fill, text) {
  context.beginPath();
  context.arc(x, y, 10, 0, 7);
  context.fillStyle = fill;
  context.fill();
  context.lineWidth = 2;
  context.strokeStyle = context.fillStyle = "#0f172a";
  context.stroke();
  context.font = "700 11px sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, x, y + 0.5);
  context.textBaseline = "alphabetic";
}
