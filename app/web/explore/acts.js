/** What visitors do on the map: point, pick, step, and find neighbours. */

import { ask, inSet, refused } from "../shared/api.js";
import * as board from "./board.js";
import { showNeighbours } from "./grid.js";
import { map, shown } from "./maps.js";
import { peek } from "./pictures.js";
import { $, change, scene, state, take } from "./root.js";
import { nearKey, nearStage, nextPoint } from "./scene.js";

/** Make the board with the first set. */
export function buildBoard() {
  if (map) return;
  board.build({
    wanted: shown,
    hover: (/** @type {number} */ point) => hover(point, true),
    pick,
    lasso: board.select,
    next: (/** @type {number} */ by) => hover(nextPoint(scene, by)),
    lassoMode: () => scene.lasso,
    current: () => scene.hovered,
  });
}

/** `pointed`: by the pointer, at which the pictures then are. @param {number} point */
function hover(point, pointed = false) {
  if (point === scene.hovered) return;
  take({ hovered: point });
  map.marks.style.cursor = point >= 0 ? "pointer" : scene.lasso ? "crosshair" : "grab";
  board.paintMarks();
  board.showCard();
  peek(point < 0 ? -1 : point % scene.frames.pairs, pointed);
}

/** Pin the pair of a point, for the other tabs too if it is of their set, and find its neighbours.
 * @param {number} point */
export function pick(point) {
  take({ nearest: null });
  if (point < 0) return change({ pin: null });
  const { pairs } = scene.frames;
  const pin = point % pairs;
  change({ pin, ...(scene.set ? {} : { vis: `row:${pin}`, tac: `row:${pin}` }) });
  return findNear(point < pairs ? 0 : 1);
}

/** Find the neighbours of the pinned pair's photo, 0, or touch, 1. @param {number} half */
export async function findNear(half) {
  const { set, frames, stop } = scene;
  const point = Number(state.pin) + frames.pairs * half;
  const key = nearKey(scene, state);
  const box = $(".card .found");
  if (box) box.textContent = "Computing this stage for the whole set…";
  try {
    const question = { point, stage: nearStage(scene, state), order: frames.orders[stop] };
    const { neighbours } = await ask(inSet("neighbours", set), question);
    if (key !== nearKey(scene, state)) return;
    take({ nearest: { key, points: neighbours } });
    showNeighbours();
    board.paintMarks();
  } catch (error) {
    refused(error, (/** @type {string} */ sentence) => box && (box.textContent = sentence));
  }
}
