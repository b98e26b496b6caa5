/** Tree, places on the map and neighbours, from the stages of many pairs at one order. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { quiet } from "./runtime.js";
import { dot, nearest, norm, rounded, roundedRow, rowOf, rowsOf, stacked, unit } from "./tensors.js";

/** @typedef {import("./desk.js").Desk} Desk */
const STEP = 32; // pairs of one run of the head: 30 ms, for which a question of the visitor may wait

/** The place of a row on a linear map (2, D + 1). @param {ArrayLike<number>} row @param {Tensor} map */
export const onLinear = (row, map) => [0, 1].map((axis) => dot([...Array.from(row), 1], rowOf(map, axis)));

/** The nodes of a group, and their cosines.
 * @param {Floats[]} units @param {[number, number]} group */
function level(units, [start, stop]) {
  const group = units.slice(start, stop);
  const cosines = group.map((a) => group.map((b) => dot(a, b)));
  return { nodes: group.map((_, i) => start + i), cosines: cosines.map(roundedRow) };
}

/** Unit rows (2N, W) of the whole set at a stage, VIS first. What a withdrawn question has begun, the next one ends.
 * @param {Desk} desk @param {SiteHead} head @param {string} stage @param {number | null} order
 * @param {() => boolean} stopped @returns {Promise<Floats[]>} */
async function featuresOf(desk, head, stage, order, stopped) {
  const key = stage === "raw" ? stage : `${stage} ${order}`;
  const { pairs } = await desk.about();
  if (desk.walk.key !== key) desk.walk = { key, vis: [], tac: [] };
  const { walk } = desk;
  while (walk.vis.length < pairs) {
    if (stopped()) throw new Refusal("Another question came first.", 499);
    const start = walk.vis.length;
    const some = await Promise.all(
      Array.from({ length: Math.min(STEP, pairs - start) }, async (_, i) => ({
        vis: await desk.row(start + i, "vis"),
        tac: await desk.row(start + i, "tac"),
      })),
    );
    const wanted = IMAGES.map((name) => `${stage}_${name}`);
    const out = stage === "raw" ? null : await desk.run(head, some, [order], wanted);
    for (const [k, name] of IMAGES.entries()) {
      const units = some.map((rows, i) => unit(out ? rowOf(out[wanted[k]], i) : rows[name]));
      walk[name].splice(start, STEP, ...units); // two questions may walk at once
    }
    await quiet();
  }
  return [...walk.vis, ...walk.tac];
}

/** @type {Record<string, Route>} */
export const FOREST = {
  /** The tree of one pair. */
  async tree(desk, question) {
    const { head, order, pair } = await desk.asked(question);
    if (!head.parents.length) throw new Refusal("This head generates no nodes: it was trained without DTG.");
    const [alone, other] = imagesOf(pair);
    const wanted = ["nodes", "shares"].map((name) => (other ? name : `${alone}_${name}`));
    const out = await desk.run(head, [pair], [order], wanted);
    const [nodes, shares] = wanted.map((name) => rowsOf(out[name]));
    const units = nodes.map(unit);
    const { classes, learned, arrangement, in_use, parents } = head;
    return {
      ...{ classes, order: order ?? learned, learned, arrangement, in_use, parents },
      nodes: nodes.map((row, n) => ({ norm: rounded(norm(row), 5), probabilities: roundedRow(shares[n]) })),
      layers: head.groups.map((group) => level(units, group)),
    };
  },

  /** For each image of a pair, its row of the set, its place on a linear map, or its neighbours and their shares, for
   * places.js. `drawn` is the stop of the map. */
  async near(desk, question, { stopped }) {
    const there = imagesOf(question);
    const ofSet = await Promise.all(there.map((name) => desk.rowOf(question[name])));
    if (!ofSet.includes(undefined))
      return { points: Object.fromEntries(there.map((name, i) => [name, { row: ofSet[i] }])) };
    const [{ order, pair }, head] = [await desk.asked(question), await desk.head()];
    const wanted = there.map((name) => (there.length > 1 ? `f_hat_${name}` : `${name}_f_hat`));
    const out = await desk.run(head, [pair], [order], wanted);
    const map = (await desk.file("places.safetensors"))[`${question.map} ${question.drawn}`];
    const all = map ? null : stacked(await featuresOf(desk, head, "f_hat", order, stopped));
    const points = there.map(async (name, i) => {
      if (ofSet[i] !== undefined) return [name, { row: ofSet[i] }];
      const row = unit(rowOf(out[wanted[i]], 0));
      if (map) return [name, { place: onLinear(row, map) }];
      const [index, share] = await desk.rule("place", row, /** @type {Tensor} */ (all));
      return [name, { index: Array.from(index.values, Number), share: share.values }];
    });
    return { points: Object.fromEntries(await Promise.all(points)) };
  },

  async neighbours(desk, { point, stage, order }, { stopped }) {
    const all = await featuresOf(desk, await desk.head(), stage, order, stopped);
    const { rules } = await desk.about();
    const near = nearest(all, all[point], rules.neighbours, point);
    return { neighbours: near.map((one) => ({ ...one, cosine: rounded(one.cosine, 4) })) };
  },
};
