/** Where a pair lies on the set's map: between the nearest points. Runs on the page, which has the map. */

import { held, own } from "../shared/held.js";
import { imagesOf } from "../shared/images.js";
import { theSet } from "../shared/theset.js";
import { sum } from "./tensors.js";

/** @typedef {{ status: number, value: any }} Reply @typedef {(point: number) => number[]} At */
const SAME = 1e-6; // of a squared distance: the point itself

/** The reply to "place". @param {string} set @param {string} body
 * @param {(path: string, question: string) => Promise<Reply>} ask gives the nearest points from the worker
 * @returns {Promise<Reply>} */
export async function placed(set, body, ask) {
  const question = JSON.parse(body);
  const { frames } = await theSet(() => {}, set === (own || held?.home) ? "" : set);
  const map = frames.positions(question.map, question.stage, frames.stop(question.order ?? frames.learned));
  const order = frames.orders[map.drawn ?? 0];
  const [[x0, y0], [x1, y1]] = map.bounds;
  /** @type {At} */
  const at = (point) =>
    [x1 - x0, y1 - y0].map((side, axis) => [x0, y0][axis] + (map.points[2 * point + axis] / 65535) * side);
  const there = imagesOf(question);
  const exact = there.every((name) => question[name].startsWith("row:"));
  const near = exact ? null : await ask("near", JSON.stringify({ ...question, order }));
  if (near && near.status !== 200) return near;
  const points = there.map((name) => {
    const [kind, row] = question[name].split(":");
    return [
      name,
      kind === "row" ? at(+row + (name === "tac" ? frames.pairs : 0)) : between(near?.value.points[name], at),
    ];
  });
  return { status: 200, value: { points: Object.fromEntries(points), order, exact } };
}

/** The mean of places, weighted by exp(-(d - nearest) / mean excess); a point of the map has its own.
 * @param {{ point: number, cosine: number }[]} around @param {At} at */
export function between(around, at) {
  const distance = around.map(({ cosine }) => Math.sqrt(Math.max(0, 2 - 2 * cosine)));
  const excess = distance.map((one) => one - distance[0]);
  const mean = sum(excess) / excess.length || 1;
  const itself = distance.map((one) => Number(one * one < SAME));
  const weight = itself[0] ? itself : excess.map((one) => Math.exp(-one / mean));
  const places = around.map(({ point }) => at(point));
  return [0, 1].map((axis) => sum(places.map((place, i) => (weight[i] / sum(weight)) * place[axis])));
}
