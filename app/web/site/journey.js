/** A pair at every stop of p, as the server gives it, but on linear maps alone: other maps place new rows between
 * neighbours, which takes the whole set at each stop. Runs in the worker. */

import { imagesOf, READINGS } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { readingsOf } from "./desk.js";
import { dot, mean, norm, rounded, roundedRow, rowOf, unit } from "./tensors.js";

const MAP = "pca";
const WEIGHTLESS = "The weights behind these frames are not here, so this pair has no tree.";

/** Return the position of a row on a linear map (2, D + 1). @param {Floats} row @param {Tensor} map */
export const onLinear = (row, map) => [0, 1].map((axis) => rounded(dot([...row, 1], rowOf(map, axis)), 4));

/** Return what the head for own pictures reads in a pair of a visitor's; null for other pairs or without such a head.
 * @param {import("./desk.js").Desk} desk @param {any} question */
async function byOwn(desk, question) {
  const { heads } = await desk.about();
  if (!heads.own || !imagesOf(question).every((name) => question[name].startsWith("image:"))) return null;
  const found = await desk.resolved({ ...question, head: "own" });
  const [out, images] = await Promise.all([desk.run(found.head, [found.pair], [null]), desk.lookedAt(found)]);
  return { classes: found.head.classes, readings: readingsOf(out, 0, found.pair), images };
}

/** @type {Record<string, Route>} */
export const JOURNEY = {
  async journey(desk, question) {
    if (question.mode) throw new Refusal(WEIGHTLESS);
    const [{ pair, head }, about, maps, own] = await Promise.all([
      desk.resolved(question),
      desk.about(),
      desk.file("places.safetensors"),
      byOwn(desk, question),
    ]);
    /** @type {[stop: number, order: number][]} */
    const stops = about.stops;
    const images = imagesOf(pair);
    const [alone, other] = images;
    const [hats, bars] = [
      images.map((name) => (other ? `f_hat_${name}` : `${name}_f_hat`)),
      images.map((name) => `f_bar_${name}`),
    ];
    const [nodes, shares] = ["nodes", "shares"].map((name) => (other ? name : `${alone}_${name}`));
    const readings = other ? READINGS : [alone];
    const trees = head.parents.length ? [nodes, shares] : [];
    const wanted = [...hats, ...bars, ...trees, ...readings.map((name) => `p_${name}`)];
    const orders = stops.map(([, order]) => order);
    const out = await desk.run(head, [pair], orders, wanted);
    /** A value for each stop. @template T @param {(at: number) => T} of */
    const each = (of) => orders.map((_, at) => of(at));
    /** A value for each node at a stop, from its row. @template T @param {string} name
     * @param {(row: Floats) => T} of */
    const ofNodes = (name, of) => (/** @type {number} */ at) =>
      head.parents.map((_, n) => of(rowOf(out[name], at * head.parents.length + n)));
    const spot = (/** @type {Floats} */ row, /** @type {number} */ at) =>
      onLinear(unit(row), maps[`${MAP} ${stops[at][0]}`]);
    const star = (/** @type {number} */ at) =>
      ofNodes(nodes, (row) =>
        spot(
          row.map((v, i) => v + mean(bars.map((name) => rowOf(out[name], at)[i]))),
          at,
        ),
      )(at);
    const places = images.map((name, i) => [name, each((at) => spot(rowOf(out[hats[i]], at), at))]);
    return {
      ...{ orders, stops: stops.map(([stop]) => stop), classes: head.classes, learned: head.learned, own },
      maps: { [MAP]: { places: Object.fromEntries(places), nodes: each(star), exact: true } },
      readings: Object.fromEntries(
        [...readings, ...(other ? [] : ["fused"])].map((name) => [
          name,
          each((at) => roundedRow(rowOf(out[`p_${other ? name : alone}`], at))),
        ]),
      ),
      tree: {
        ...{ parents: head.parents, in_use: head.in_use },
        probabilities: each(ofNodes(shares, roundedRow)),
        norms: each(ofNodes(nodes, (row) => rounded(norm(row), 4))),
      },
      images: await desk.lookedAt({ pair, head, order: null }),
    };
  },
};
