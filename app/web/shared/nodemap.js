/** A small map of one stage with a pair and its tree nodes. */

import { ask, attempt } from "./api.js";
import { Cloud } from "./cloud.js";
import { shownBy } from "./filters.js";
import { orderText } from "./frames.js";
import { layersOf } from "./layers.js";
import { axes, axisNames } from "./marks.js";
import { isDark, onTheme, TAC_COLOUR, VIS_COLOUR } from "./palette.js";
import { listen } from "./pointer.js";
import { change, state, watch } from "./store.js";

const STAGE = "f_hat";
const WAIT = 180; // milliseconds that p must rest before a request

/** Returns show(question, order): the question has VIS and TAC; null shows the points only. */
export function nodeMap(panel, frames, { nodes = true } = {}) {
  const box = panel.querySelector(".still");
  const note = panel.querySelector(".where-note");
  /** @type {any} */
  let placed = null;
  let asking = new AbortController();
  let waiting = 0;
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

  return function show(question, order) {
    points(order);
    clearTimeout(waiting);
    asking.abort();
    if (!question) {
      placed = null;
      note.textContent = "";
      return;
    }
    waiting = setTimeout(async () => {
      asking = new AbortController();
      await attempt(async () => {
        placed = await ask("place", { ...question, order, stage: STAGE, map: kind(), nodes }, asking.signal);
        note.textContent = `Pale: all pairs at p = ${orderText(placed.order)}. ${placed.exact ? "Places are exact." : placed.of_set && !nodes ? "Its place is the pair’s." : `${placed.of_set ? "The nodes’ places" : "Places"} are estimated between the nearest neighbours.`} Click a point to choose its pair.`;
        cloud.paintMarks();
      }, note);
    }, WAIT);
  };
}

/** CSS pixels of a position in map units.
 * @returns {[number, number]} */
function at(cloud, [x, y]) {
  const { scale, middle, ox, oy } = cloud.transform();
  return [(ox + scale * (x - middle.x)) / cloud.ratio, (oy - scale * (y - middle.y)) / cloud.ratio];
}

function paint(context, cloud, { points, nodes }) {
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
  nodes.forEach((node, i) => disc(context, at(cloud, node), paper, ink, ink, `${i + 1}`));
  if (vis) disc(context, vis, VIS_COLOUR, "#0f172a", "#0f172a", "V");
  if (tac) disc(context, tac, TAC_COLOUR, "#0f172a", "#0f172a", "T");
}

function disc(context, [x, y], fill, edge, ink, text) {
  context.beginPath();
  context.arc(x, y, 10, 0, 7);
  context.fillStyle = fill;
  context.fill();
  context.lineWidth = 2;
  context.strokeStyle = edge;
  context.stroke();
  context.font = "700 11px sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillStyle = ink;
  context.fillText(text, x, y + 0.5);
  context.textBaseline = "alphabetic";
}
