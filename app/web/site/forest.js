/** Tree, places on the map and neighbours, from the stages of many pairs at one order. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { orderIn, pairOf } from "./desk.js";
import { Refused } from "./refusal.js";
import { quiet } from "./runtime.js";
import { dot, norm, rounded, rowOf, unit } from "./tensors.js";

const STEP = 32; // pairs of one run of the head: 30 ms, for which a question of the visitor may wait
const NEAREST = 6;
const AROUND = 8; // points of the map between which a new one is placed
const KEPT = 2; // stages of the whole set

/** The outputs of one pair; of one image alone, those without the other. */
async function single(desk, head, pair, order, stages = []) {
  const there = imagesOf(pair);
  const alone = there.length === 1 ? `${there[0]}_` : "";
  const any = pair[there[0]];
  const wanted = [...(head.parents.length ? [`${alone}nodes`, `${alone}shares`] : []), ...stages];
  const out = await desk.models.stages(head, { vis: [pair.vis ?? any], tac: [pair.tac ?? any] }, order, wanted);
  return { there, alone, out, nodes: out[`${alone}nodes`], shares: out[`${alone}shares`] };
}

const rowsOf = ({ shape, values }, pair) =>
  Array.from({ length: shape[1] }, (_, n) => {
    const start = (pair * shape[1] + n) * shape[2];
    return values.subarray(start, start + shape[2]);
  });

/** The nodes of a group: their cosines, and the distance of these from the identity. */
function level(units, [start, stop]) {
  const numbers = Array.from({ length: stop - start }, (_, i) => start + i);
  const cosines = numbers.map((n) => numbers.map((m) => dot(units[n], units[m])));
  const off = cosines.flatMap((row, i) => row.map((value, j) => (value - Number(i === j)) ** 2));
  return {
    nodes: numbers,
    cosines: cosines.map((row) => rounded(row)),
    nod: rounded([Math.sqrt(off.reduce((sum, value) => sum + value, 0))], 5)[0],
  };
}

/** The tree of one pair. */
async function tree(desk, question) {
  const head = await desk.models.head(question.head);
  const order = orderIn(question.order) ?? head.learned;
  if (!head.parents.length) throw new Refused("This head generates no nodes: it was trained without DTG.");
  const found = await single(desk, head, await pairOf(desk, question), order);
  const [nodes, shares] = [found.nodes, found.shares].map((rows) => rowsOf(rows, 0));
  const units = nodes.map((row) => unit(row));
  return {
    classes: head.classes,
    order,
    learned: head.learned,
    arrangement: head.arrangement,
    in_use: head.in_use,
    source: head.source,
    parents: head.parents,
    nodes: nodes.map((row, n) => ({ norm: rounded([norm(row)], 5)[0], probabilities: rounded(shares[n]) })),
    layers: head.groups.map((group) => level(units, group)),
  };
}

/** Unit rows (2N, W) of the whole set at a stage, VIS first. What a withdrawn question has begun, the next one ends. */
async function featuresOf(desk, head, stage, order, stopped) {
  const key = stage === "raw" ? stage : `${stage} ${order.toFixed(6)}`;
  const { pairs } = await desk.models.about();
  desk.features ??= new Map(); // key -> {all, done: pairs of it}
  if (!desk.features.has(key)) {
    if (desk.features.size >= KEPT) desk.features.delete(desk.features.keys().next().value);
    desk.features.set(key, { all: new Array(2 * pairs), done: 0 });
  }
  const walk = desk.features.get(key);
  const wanted = IMAGES.map((name) => `${stage}_${name}`);
  while (walk.done < pairs) {
    if (stopped()) throw new Refused("Another question came first.", 499);
    const start = walk.done;
    const some = Array.from({ length: Math.min(STEP, pairs - start) }, (_, i) => start + i);
    const rows = await Promise.all(IMAGES.map((name) => Promise.all(some.map((pair) => desk.models.row(pair, name)))));
    const out = stage === "raw" ? null : await desk.models.stages(head, { vis: rows[0], tac: rows[1] }, order, wanted);
    for (const [at, name] of wanted.entries())
      for (const [i, pair] of some.entries())
        walk.all[at * pairs + pair] = Float32Array.from(unit(out ? rowOf(out[name], i) : rows[at][i]));
    walk.done = Math.max(walk.done, start + some.length);
    await quiet();
  }
  return walk.all;
}

function nearest(all, query, count, own = -1) {
  const cosines = Float64Array.from(all, (row, i) => (i === own ? -2 : dot(query, row)));
  const order = [...cosines.keys()].sort((a, b) => cosines[b] - cosines[a]).slice(0, count);
  return order.map((point) => ({ point, cosine: cosines[point] }));
}

/** The points of the set nearest to a pair's images. */
async function near(desk, question, stopped) {
  const head = await desk.models.head();
  const order = orderIn(question.order) ?? head.learned;
  const pair = await pairOf(desk, question);
  const bars = imagesOf(pair).map((name) => `f_bar_${name}`);
  const stages = bars.length > 1 ? IMAGES.map((name) => `f_hat_${name}`) : bars;
  const { there, out, nodes } = await single(desk, head, pair, order, stages);
  const grown = nodes ? rowsOf(nodes, 0) : [];
  const hat = (name) => {
    if (there.length > 1) return rowOf(out[`f_hat_${name}`], 0);
    const mean = (i) => grown.reduce((sum, row) => sum + row[i], 0) / (grown.length || 1);
    return rowOf(out[`f_bar_${name}`], 0).map((value, i) => value + (head.in_use ? mean(i) : 0));
  };
  const all = await featuresOf(desk, head, "f_hat", order, stopped);
  const around = (row) => nearest(all, unit(row), AROUND);
  return { points: Object.fromEntries(there.map((name) => [name, around(hat(name))])) };
}

async function neighbours(desk, { point, stage, order }, stopped) {
  const head = await desk.models.head();
  const all = await featuresOf(desk, head, stage, orderIn(order) ?? head.learned, stopped);
  const found = nearest(all, all[point], NEAREST, point);
  return { neighbours: found.map((one) => ({ ...one, cosine: rounded([one.cosine], 4)[0] })) };
}

export const FOREST = { tree, near, neighbours };
