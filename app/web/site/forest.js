/** Tree, places on the map and neighbours, from the stages of many pairs at one order. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { orderIn, pairOf } from "./desk.js";
import { Refused } from "./refusal.js";
import { quiet } from "./runtime.js";
import { best, dot, norm, rounded, rowOf, unit } from "./tensors.js";

const STEP = 32; // pairs of one run of the head: 30 ms, for which a question of the visitor may wait
const NEAREST = 6;
const AROUND = 8; // points of the map between which a new one is placed
const KEPT = 2; // stages of the whole set

/** Run the head on pairs of the set by number, from place `at` of them on; `take(out, count, start)` gets the outputs
 * of each run. */
async function walk(desk, head, numbers, order, wanted, take, at = 0) {
  for (let start = at; start < numbers.length; start += STEP) {
    const some = numbers.slice(start, start + STEP);
    const rows = await Promise.all(IMAGES.map((name) => Promise.all(some.map((one) => desk.models.row(one, name)))));
    take(await desk.models.stages(head, { vis: rows[0], tac: rows[1] }, order, wanted), some.length, start);
    await quiet();
  }
}

/** The outputs of one pair; of one image alone, those without the other. */
async function single(desk, head, pair, order, stages = []) {
  const there = imagesOf(pair);
  const alone = there.length === 1 ? `${there[0]}_` : "";
  const any = pair[there[0]];
  const wanted = [...(head.parents.length ? [`${alone}nodes`, `${alone}shares`] : []), ...stages];
  const out = await desk.models.stages(head, { vis: [pair.vis ?? any], tac: [pair.tac ?? any] }, order, wanted);
  return { there, alone, out, nodes: out[`${alone}nodes`], shares: out[`${alone}shares`] };
}

/** Means over pairs of what the tree shows of its nodes. */
class Means {
  constructor(head, count) {
    this.head = head;
    this.pairs = 0;
    this.known = 0;
    this.lengths = new Float64Array(count);
    this.shares = Array.from({ length: count }, () => new Float64Array(head.classes.length));
    this.right = new Float64Array(count);
    this.levels = head.groups.map(([start, stop]) => ({
      start,
      stop,
      cosines: Array.from({ length: stop - start }, () => new Float64Array(stop - start)),
      nod: 0,
    }));
  }

  /** nodes (N, D) and shares (N, K) of one pair; label: of the head's classes, -1 for none. */
  add(nodes, shares, label) {
    this.pairs += 1;
    this.known += label >= 0 ? 1 : 0;
    const units = nodes.map((row, n) => {
      this.lengths[n] += norm(row);
      shares[n].forEach((share, k) => {
        this.shares[n][k] += share;
      });
      if (label >= 0 && best(shares[n]) === label) this.right[n] += 1;
      return unit(row);
    });
    for (const level of this.levels) {
      let apart = 0;
      for (let a = level.start; a < level.stop; a++)
        for (let b = level.start; b < level.stop; b++) {
          const cosine = dot(units[a], units[b]);
          level.cosines[a - level.start][b - level.start] += cosine;
          apart += a === b ? 0 : cosine * cosine;
        }
      level.nod += Math.sqrt(apart);
    }
  }

  /** The records of the page; `judged` adds the accuracy of each node. */
  records(judged) {
    const mean = (row) => rounded(Array.from(row, (value) => value / this.pairs));
    return {
      pairs: this.pairs,
      nodes: [...this.lengths].map((length, n) => ({
        norm: rounded([length / this.pairs], 5)[0],
        probabilities: mean(this.shares[n]),
        ...(judged && { right: this.known ? rounded([this.right[n] / this.known], 5)[0] : null }),
      })),
      layers: this.levels.map(({ start, stop, cosines, nod }) => ({
        nodes: Array.from({ length: stop - start }, (_, i) => start + i),
        cosines: cosines.map(mean),
        nod: rounded([nod / this.pairs], 5)[0],
      })),
    };
  }
}

const rowsOf = ({ shape, values }, pair) =>
  Array.from({ length: shape[1] }, (_, n) => {
    const start = (pair * shape[1] + n) * shape[2];
    return values.subarray(start, start + shape[2]);
  });

/** The tree of one pair, or the mean over a domain's pairs. */
async function tree(desk, question) {
  const head = await desk.models.head(question.head);
  const order = orderIn(question.order) ?? head.learned;
  if (!head.parents.length) throw new Refused("This head generates no nodes: it was trained without DTG.");
  const means = new Means(head, head.parents.length);
  const { domain } = question;
  if (domain) {
    const { set } = await desk.models.about();
    const place = set.domains.indexOf(domain);
    const numbers = [...set.domain.keys()].filter((pair) => set.domain[pair] === place);
    if (!numbers.length) throw new Refused(`The domain '${String(domain).slice(0, 80)}' has no pairs here.`);
    const labels = numbers.map((pair) => head.classes.indexOf(set.classes[set.label[pair]]));
    await walk(desk, head, numbers, order, ["nodes", "shares"], (out, count) => {
      for (let i = 0; i < count; i++) means.add(rowsOf(out.nodes, i), rowsOf(out.shares, i), labels[means.pairs]);
    });
  } else {
    const { nodes, shares } = await single(desk, head, await pairOf(desk, question), order);
    means.add(rowsOf(nodes, 0), rowsOf(shares, 0), -1);
  }
  return {
    classes: head.classes,
    order,
    learned: head.learned,
    arrangement: head.arrangement,
    in_use: head.in_use,
    source: head.source,
    parents: head.parents,
    ...means.records(Boolean(domain)),
  };
}

/** Unit rows (2N, W) of the whole set at a stage, VIS first. */
async function featuresOf(desk, head, stage, order, stopped) {
  const key = stage === "raw" ? stage : `${stage} ${order.toFixed(6)}`;
  desk.features ??= new Map();
  if (desk.features.has(key)) return desk.features.get(key);
  const { pairs } = await desk.models.about();
  if (desk.begun?.key !== key) desk.begun = { key, all: new Array(2 * pairs), at: 0 };
  const { begun } = desk; // of a question that was withdrawn, the next one has the part that is done
  const { all } = begun;
  const put = (modality, pair, row) => {
    all[modality * pairs + pair] = Float32Array.from(unit(row));
  };
  const numbers = Array.from({ length: pairs }, (_, pair) => pair);
  if (stage === "raw") {
    for (const pair of numbers)
      for (const modality of [0, 1]) put(modality, pair, await desk.models.row(pair, IMAGES[modality]));
  } else {
    const wanted = IMAGES.map((name) => `${stage}_${name}`);
    const take = (out, count, start) => {
      if (stopped()) throw new Refused("Another question came first.", 499);
      for (let i = 0; i < count; i++) wanted.forEach((name, modality) => put(modality, start + i, rowOf(out[name], i)));
      begun.at = Math.max(begun.at, start + count);
    };
    await walk(desk, head, numbers, order, wanted, take, begun.at);
  }
  desk.begun = null;
  if (desk.features.size >= KEPT) desk.features.delete(desk.features.keys().next().value);
  desk.features.set(key, all);
  return all;
}

function nearest(all, query, count, own = -1) {
  const cosines = Float64Array.from(all, (row, i) => (i === own ? -2 : dot(query, row)));
  const order = [...cosines.keys()].sort((a, b) => cosines[b] - cosines[a]).slice(0, count);
  return order.map((point) => ({ point, cosine: cosines[point] }));
}

/** The points of the set nearest to a pair's images and to the nodes of its tree. */
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
  return {
    points: Object.fromEntries(there.map((name) => [name, around(hat(name))])),
    nodes: question.nodes ? grown.map(around) : [],
  };
}

async function neighbours(desk, { point, stage, order }, stopped) {
  const head = await desk.models.head();
  const { pairs } = await desk.models.about();
  if (!(Number.isInteger(point) && point >= 0 && point < 2 * pairs))
    throw new Refused(`No point has the number ${String(point).slice(0, 20)}; choose one on the map.`);
  const all = await featuresOf(desk, head, stage, orderIn(order) ?? head.learned, stopped);
  const found = nearest(all, all[point], NEAREST, point);
  return { neighbours: found.map((one) => ({ ...one, cosine: rounded([one.cosine], 4)[0] })) };
}

export const FOREST = { tree, near, neighbours };
