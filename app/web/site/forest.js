/** Tree and neighbours, from the stages of many pairs at one order. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { quiet } from "./runtime.js";
import { dot, nearest, norm, rounded, roundedRow, rowOf, rowsOf, unit } from "./tensors.js";

/** @typedef {import("./desk.js").Desk} Desk */
const STEP = 32; // pairs of one run of the head: 30 ms, for which a question of the visitor may wait

/** Return the nodes of a group, and their cosines.
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
    const { head, order, pair } = await desk.resolved(question);
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

  async neighbours(desk, { point, stage, order }, { stopped }) {
    const all = await featuresOf(desk, await desk.head(), stage, order, stopped);
    const { rules } = await desk.about();
    const near = nearest(all, all[point], rules.neighbours, point);
    return { neighbours: near.map((neighbour) => ({ ...neighbour, cosine: rounded(neighbour.cosine, 4) })) };
  },
};
