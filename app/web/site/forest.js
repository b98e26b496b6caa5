/** Tree, places on the map and neighbours, from the stages of many pairs at one order. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Refused } from "./refusal.js";
import { PAIR } from "./rules.js";
import { quiet } from "./runtime.js";
import { dot, mean, norm, rounded, roundedRow, rowOf, unit } from "./tensors.js";

/** @typedef {import("./desk.js").Desk} Desk */
const STEP = 32; // pairs of one run of the head: 30 ms, for which a question of the visitor may wait
const AROUND = 8; // points of the map between which a new one is placed
const KEPT = 2; // stages of the whole set

/** The outputs of one pair and the rows of its tree; of one image alone, those without the other.
 * @param {Desk} desk @param {Asked} asked @param {string[]} stages */
async function single(desk, { head, pair, order }, stages = []) {
  const there = imagesOf(pair);
  const alone = there.length === 1 ? `${there[0]}_` : "";
  const names = head.parents.length ? [`${alone}nodes`, `${alone}shares`] : [];
  const any = /** @type {Floats} */ (pair[there[0]]);
  const rows = { vis: [pair.vis ?? any], tac: [pair.tac ?? any] };
  const out = await desk.stages(head, rows, order ?? head.learned, [...names, ...stages]);
  const [nodes, shares] = names.map((name) => {
    const [, count, width] = out[name].shape;
    return head.parents.map((_, n) => rowOf({ shape: [count, width], values: out[name].values }, n));
  });
  return { there, out, nodes, shares };
}

/** The nodes of a group: their cosines, and the distance of these from the identity.
 * @param {Floats[]} units @param {[number, number]} group */
function level(units, [start, stop]) {
  const group = units.slice(start, stop);
  const cosines = group.map((a) => group.map((b) => dot(a, b)));
  const off = cosines.flatMap((row, i) => row.map((value, j) => value - Number(i === j)));
  return { nodes: group.map((_, i) => start + i), cosines: cosines.map(roundedRow), nod: rounded(norm(off), 5) };
}

/** Unit rows (2N, W) of the whole set at a stage, VIS first. What a withdrawn question has begun, the next one ends.
 * @param {Desk} desk @param {SiteHead} head @param {string} stage @param {number} order @param {() => boolean} stopped */
async function featuresOf(desk, head, stage, order, stopped) {
  const key = stage === "raw" ? stage : `${stage} ${order.toFixed(6)}`;
  const { pairs } = await desk.about();
  const walk = desk.features.get(key) ?? { all: new Array(2 * pairs), done: 0 };
  if (!desk.features.has(key) && desk.features.size >= KEPT) desk.features.delete([...desk.features.keys()][0]);
  desk.features.set(key, walk);
  while (walk.done < pairs) {
    if (stopped()) throw new Refused("Another question came first.", 499);
    const start = walk.done;
    const some = Array.from({ length: Math.min(STEP, pairs - start) }, (_, i) => start + i);
    const [vis, tac] = await Promise.all(IMAGES.map((name) => Promise.all(some.map((pair) => desk.row(pair, name)))));
    const wanted = IMAGES.map((name) => `${stage}_${name}`);
    const out = stage === "raw" ? null : await desk.stages(head, { vis, tac }, order, wanted);
    for (const [i, pair] of some.entries()) {
      walk.all[pair] = Float32Array.from(unit(out ? rowOf(out[wanted[0]], i) : vis[i]));
      walk.all[pairs + pair] = Float32Array.from(unit(out ? rowOf(out[wanted[1]], i) : tac[i]));
    }
    walk.done = Math.max(walk.done, start + some.length);
    await quiet();
  }
  return walk.all;
}

/** The points nearest to a row. @param {Floats[]} all @param {Floats} query @param {number} count */
function nearest(all, query, count, own = -1) {
  const cosines = all.map((row, i) => (i === own ? -2 : dot(query, row)));
  const points = [...cosines.keys()].sort((a, b) => cosines[b] - cosines[a]).slice(0, count);
  return points.map((point) => ({ point, cosine: cosines[point] }));
}

/** @type {Record<string, Route>} */
export const FOREST = {
  /** The tree of one pair. */
  async tree(desk, question) {
    const asked = await desk.asked(question);
    const { head, order } = asked;
    if (!head.parents.length) throw new Refused("This head generates no nodes: it was trained without DTG.");
    const { nodes, shares } = await single(desk, asked);
    const units = nodes.map(unit);
    return {
      classes: head.classes,
      order: order ?? head.learned,
      learned: head.learned,
      arrangement: head.arrangement,
      in_use: head.in_use,
      source: head.source,
      parents: head.parents,
      nodes: nodes.map((row, n) => ({ norm: rounded(norm(row), 5), probabilities: roundedRow(shares[n]) })),
      layers: head.groups.map((group) => level(units, group)),
    };
  },

  /** The points of the set nearest to a pair's images; places.js asks for them. */
  async near(desk, question, { stopped }) {
    const asked = { ...(await desk.asked(question)), head: await desk.head() };
    const { head, order, pair } = asked;
    const bars = imagesOf(pair).map((name) => `f_bar_${name}`);
    const whole = bars.length > 1;
    const { there, out, nodes = [] } = await single(desk, asked, whole ? IMAGES.map((name) => `f_hat_${name}`) : bars);
    const grown = (/** @type {number} */ i) => (head.in_use && nodes.length ? mean(nodes.map((row) => row[i])) : 0);
    const hat = (/** @type {Modality} */ name) =>
      whole ? rowOf(out[`f_hat_${name}`], 0) : rowOf(out[`f_bar_${name}`], 0).map((value, i) => value + grown(i));
    const all = await featuresOf(desk, head, "f_hat", order ?? head.learned, stopped);
    return { points: Object.fromEntries(there.map((name) => [name, nearest(all, unit(hat(name)), AROUND)])) };
  },

  async neighbours(desk, { point, stage, order }, { stopped }) {
    const head = await desk.head();
    const all = await featuresOf(desk, head, stage, order ?? head.learned, stopped);
    const near = nearest(all, all[point], PAIR.NEIGHBOURS, point);
    return { neighbours: near.map((one) => ({ ...one, cosine: rounded(one.cosine, 4) })) };
  },
};
