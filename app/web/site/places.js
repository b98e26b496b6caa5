/** Where a pair lies on the set's map: between the nearest points. Runs on the page, which has the map. */

import { held, own } from "../shared/held.js";
import { imagesOf } from "../shared/images.js";
import { theSet } from "../shared/theset.js";

const SAME = 1e-6; // of a squared distance: the point itself

/** {status, value}: the reply to "place". `ask("near", question)` gives the nearest points from the worker. */
export async function placed(set, body, ask) {
  const question = JSON.parse(body);
  const { frames } = await theSet(() => {}, set === (own || held?.home) ? "" : set);
  const map = frames.positions(question.map, question.stage, frames.stop(question.order ?? frames.learned));
  const order = frames.orders[map.drawn];
  const [[x0, y0], [x1, y1]] = map.bounds;
  const at = (point) => [
    x0 + (map.points[2 * point] / 65535) * (x1 - x0),
    y0 + (map.points[2 * point + 1] / 65535) * (y1 - y0),
  ];
  const there = imagesOf(question);
  const known = there.every((name) => question[name].startsWith("row:"));
  const { status, value: found } = known
    ? { status: 200, value: { points: Object.fromEntries(there.map((name) => [name, []])) } }
    : await ask("near", JSON.stringify({ ...question, order }));
  if (status !== 200) return { status, value: found };
  const points = Object.fromEntries(
    Object.entries(found.points).map(([name, around]) => {
      const row = /^row:(\d+)$/.exec(question[name])?.[1];
      return [name, row ? at(+row + (name === "tac" ? frames.pairs : 0)) : between(around, at)];
    }),
  );
  const exact = Object.keys(points).every((name) => question[name].startsWith("row:"));
  return { status, value: { points, order, exact } };
}

/** The mean of places, weighted by exp(-(d - nearest) / mean excess); a point of the map has its own. */
export function between(around, at) {
  const distance = around.map(({ cosine }) => Math.sqrt(Math.max(0, 2 - 2 * cosine)));
  const excess = distance.map((one) => one - distance[0]);
  const mean = excess.reduce((a, b) => a + b, 0) / excess.length || 1;
  const itself = distance.map((one) => Number(one * one < SAME));
  const weight = itself[0] ? itself : excess.map((one) => Math.exp(-one / mean));
  const sum = weight.reduce((a, b) => a + b, 0);
  return [0, 1].map((axis) => around.reduce((total, { point }, i) => total + (weight[i] / sum) * at(point)[axis], 0));
}
