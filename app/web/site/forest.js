/** Tree, places on the map and neighbours, from the stages of many pairs at one order. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { PAIR } from "./rules.js";
import { quiet } from "./runtime.js";
import { dot, mean, nearest, norm, rounded, roundedRow, rowOf, unit } from "./tensors.js";

/** @typedef {import("./desk.js").Desk} Desk */
const STEP = 32; // pairs of one run of the head: 30 ms, for which a question of the visitor may wait
const AROUND = 8; // points of the map between which a new one is placed
const KEPT = 2; // stages of the whole set

/** The outputs of one pair and the rows of its tree; of one image alone, those without the other.
 * @param {Desk} desk @param {Asked} asked @param {string[]} stages */
async function single(desk, { head, pair, order }, stages = []) {
  const there = imagesOf(pair);
  const any = /** @type {Floats} */ (pair[there[0]]);
  const names = ["nodes", "shares"].map((name) => (there.length > 1 ? name : `${there[0]}_${name}`));
  const wanted = head.parents.length ? [...names, ...stages] : stages;
  const out = await desk.stages(head, { vis: [pair.vis ?? any], tac: [pair.tac ?? any] }, order, wanted);
  const [nodes, shares] = names.map((name) => head.parents.map((_, n) => rowOf(out[name], n)));
  return { there, out, nodes, shares };
}

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
  /** @type {Record<Modality, Floats[]>} */
  const walk = desk.features.get(key) ?? { vis: [], tac: [] };
  desk.features.delete(key);
  for (const old of [...desk.features.keys()].slice(KEPT - 1)) desk.features.delete(old);
  desk.features.set(key, walk);
  while (walk.vis.length < pairs) {
    if (stopped()) throw new Refusal("Another question came first.", 499);
    const start = walk.vis.length;
    const some = Array.from({ length: Math.min(STEP, pairs - start) }, (_, i) => start + i);
    const [vis, tac] = await Promise.all(IMAGES.map((name) => Promise.all(some.map((pair) => desk.row(pair, name)))));
    const wanted = IMAGES.map((name) => `${stage}_${name}`);
    const out = stage === "raw" ? null : await desk.stages(head, { vis, tac }, order, wanted);
    for (const [k, rows] of [vis, tac].entries()) {
      const units = rows.map((row, i) => unit(out ? rowOf(out[wanted[k]], i) : row));
      walk[IMAGES[k]].splice(start, STEP, ...units); // two questions may walk at once
    }
    await quiet();
  }
  return [...walk.vis, ...walk.tac];
}

/** @type {Record<string, Route>} */
export const FOREST = {
  /** The tree of one pair. */
  async tree(desk, question) {
    const asked = await desk.asked(question);
    const { head, order } = asked;
    if (!head.parents.length) throw new Refusal("This head generates no nodes: it was trained without DTG.");
    const { nodes, shares } = await single(desk, asked);
    const units = nodes.map(unit);
    const { classes, learned, arrangement, in_use, source, parents } = head;
    return {
      ...{ classes, order: order ?? learned, learned, arrangement, in_use, source, parents },
      nodes: nodes.map((row, n) => ({ norm: rounded(norm(row), 5), probabilities: roundedRow(shares[n]) })),
      layers: head.groups.map((group) => level(units, group)),
    };
  },

  /** The points of the set nearest to a pair's images; places.js asks for them. */
  async near(desk, question, { stopped }) {
    const asked = { ...(await desk.asked(question)), head: await desk.head() };
    const { head, order, pair } = asked;
    const stage = imagesOf(pair).length > 1 ? "f_hat" : "f_bar"; // to one image alone, its nodes are added here
    const { there, out, nodes } = await single(
      desk,
      asked,
      imagesOf(pair).map((name) => `${stage}_${name}`),
    );
    const grown = stage === "f_bar" && head.in_use && nodes.length > 0;
    const all = await featuresOf(desk, head, "f_hat", order, stopped);
    const points = there.map((name) => {
      const row = rowOf(out[`${stage}_${name}`], 0).map(
        (value, i) => value + (grown ? mean(nodes.map((node) => node[i])) : 0),
      );
      return [name, nearest(all, unit(row), AROUND)];
    });
    return { points: Object.fromEntries(points) };
  },

  async neighbours(desk, { point, stage, order }, { stopped }) {
    const all = await featuresOf(desk, await desk.head(), stage, order, stopped);
    const near = nearest(all, all[point], PAIR.NEIGHBOURS, point);
    return { neighbours: near.map((one) => ({ ...one, cosine: rounded(one.cosine, 4) })) };
  },
};
