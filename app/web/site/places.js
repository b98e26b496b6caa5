/** Where a pair lies on the set's map. Runs on the page, which has the map. */

import { held, own } from "../shared/held.js";
import { imagesOf } from "../shared/images.js";
import { OUTPUT } from "../shared/stages.js";
import { theSet } from "../shared/theset.js";
import { sum } from "./tensors.js";

/** @typedef {{ status: number, value: any }} Reply @typedef {(point: number) => number[]} At */

/** The reply to "place". @param {string} set @param {string} body
 * @param {(path: string, question: string) => Promise<Reply>} ask gives places or neighbours from the worker
 * @returns {Promise<Reply>} */
export async function placed(set, body, ask) {
  const question = JSON.parse(body);
  const { frames } = await theSet(() => {}, set === (own || held?.home) ? "" : set);
  const map = frames.positions(question.map, OUTPUT, frames.stop(question.order ?? frames.learned));
  const drawn = map.drawn ?? 0;
  const order = frames.orders[drawn];
  const [[x0, y0], [x1, y1]] = map.bounds;
  /** @type {At} */
  const at = (point) =>
    [x1 - x0, y1 - y0].map((side, axis) => [x0, y0][axis] + (map.points[2 * point + axis] / 65535) * side);
  const there = imagesOf(question);
  const ofSet = there.every((name) => question[name].startsWith("row:"));
  const near = ofSet ? null : await ask("near", JSON.stringify({ ...question, order, drawn }));
  if (near && near.status !== 200) return near;
  const found = near?.value.points ?? {};
  const exact = there.map((name) => {
    const row = ofSet ? +question[name].slice("row:".length) : found[name].row;
    return row === undefined ? found[name].place : at(row + (name === "tac" ? frames.pairs : 0));
  });
  const points = there.map((name, i) => [name, exact[i] ?? between(found[name], at)]);
  return { status: 200, value: { points: Object.fromEntries(points), order, exact: exact.every(Boolean) } };
}

/** The mean of the places of neighbours by their shares. @param {{ index: number[], share: number[] }} around @param {At} at */
function between({ index, share }, at) {
  const places = index.map(at);
  return [0, 1].map((axis) => sum(places.map((place, i) => share[i] * place[axis])));
}
