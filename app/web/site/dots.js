/** Fill the dots that are printed on a gel: `omnivat/data/grid.py` and `dots.py`, with equal results. No DOM here. */

import { dot, mean, norm, sum } from "./tensors.js";

const [SIDE, SMALLEST, SWEEPS] = [224, 64, 2]; // the numbers of grid.py and dots.py
const [WIDEST, LONGEST, SHORTEST] = [0.085, 0.28, 11];
const [FAINTEST, FAINT, MOST] = [26, [0.35, 0.7], 256];
const [NODES, SUPPORT, STRAY] = [16, 0.22, 0.24];
/** @typedef {{ width: number, height: number, values: Float64Array }} Plane
 * @typedef {{ x: number, y: number, depth: number }} Spot
 * @typedef {{ nodes: Spot[], steps: number[][], darkness: number }} Grid */

/** As Python rounds. @param {number} x */
const even = (x) => (Math.abs(x % 1) === 0.5 ? 2 * Math.round(x / 2) : Math.round(x));
/** @param {number[]} values */
const median = (values) => {
  const sorted = Float64Array.from(values).sort();
  return (sorted[(sorted.length - 1) >> 1] + sorted[sorted.length >> 1]) / 2;
};

/** Return a plane of numbers, each made from its place.
 * @param {number} width @param {number} height
 * @param {(x: number, y: number, at: number) => number} make @returns {Plane} */
function plane(width, height, make) {
  const values = new Float64Array(width * height);
  for (let y = 0, at = 0; y < height; y++) for (let x = 0; x < width; x++, at++) values[at] = make(x, y, at);
  return { width, height, values };
}

/** Return the value at a place; beyond the edge, that of the edge.
 * @param {Plane} source @param {number} x @param {number} y */
const valueAt = ({ width, height, values }, x, y) =>
  values[Math.min(Math.max(y, 0), height - 1) * width + Math.min(Math.max(x, 0), width - 1)];

/** Return the sum of a square of pixels, by its first pixel.
 * @param {Plane} source @param {number} left @param {number} top
 * @param {number} size */
function sumOf(source, left, top, size) {
  let total = 0;
  for (let y = top; y < top + size; y++) for (let x = left; x < left + size; x++) total += valueAt(source, x, y);
  return total;
}

/** Return the sums of the squares that are up to `reach` around each pixel.
 * @param {Plane} source @param {number} reach */
const sums = (source, reach) =>
  plane(source.width, source.height, (x, y) => sumOf(source, x - reach, y - reach, 2 * reach + 1));

/** Return the largest or smallest value of the square of pixels that are at most `reach` from each pixel.
 * @param {Plane} source @param {number} reach @param {(...values: number[]) => number} fold */
function extremes(source, reach, fold = Math.max) {
  const wider = (/** @type {Plane} */ from, /** @type {number} */ right, /** @type {number} */ down) =>
    plane(source.width, source.height, (x, y, at) =>
      fold(from.values[at], valueAt(from, x - right, y - down), valueAt(from, x + right, y + down)),
    );
  let now = source;
  for (let done = 0, step = 0; done < reach; done += step) {
    step = Math.min(2 * done + 1, reach - done);
    now = wider(wider(now, step, 0), 0, step);
  }
  return now;
}

/** Return the groups of linked places that are good.
 * @param {ArrayLike<unknown>} good
 * @param {(at: number) => number[]} links those that are nowhere are not good @returns {number[][]} */
function groups(good, links) {
  const free = Uint8Array.from(good, Number);
  /** @type {number[][]} */
  const all = [];
  for (let from = 0; from < free.length; from++) {
    const group = free[from] ? [from] : [];
    free[from] = 0;
    for (const at of group) {
      const fresh = links(at).filter((to) => free[to]);
      for (const to of fresh) free[to] = 0;
      group.push(...fresh);
    }
    if (group.length) all.push(group);
  }
  return all;
}

/** Return the pixels that share an edge with one; -1 beyond the rim.
 * @param {number} width
 * @returns {(at: number) => number[]} */
const edges = (width) => (at) => [at - width, at + width, at % width ? at - 1 : -1, (at + 1) % width ? at + 1 : -1];

/** @param {Plane} source */
const reduction = ({ width, height }) => Math.max(1, even(Math.min(width, height) / SIDE));

/** Return the means of squares of `scale` pixels. @param {Plane} source @param {number} scale */
const reduced = (source, scale) =>
  plane(Math.floor(source.width / scale), Math.floor(source.height / scale), (x, y) =>
    Math.floor(sumOf(source, x * scale, y * scale, scale) / scale ** 2),
  );

/** Return how dark each pixel is beside what is around it, 0 to 255. @param {Plane} brightest */
function darkness(brightest) {
  const { width, height, values } = brightest;
  const reach = Math.floor((WIDEST * Math.min(width, height)) / 2);
  const closed = extremes(extremes(brightest, reach), reach, Math.min).values;
  return plane(width, height, (_, __, at) => Math.floor(((closed[at] - values[at]) * 255) / Math.max(closed[at], 24)));
}

/** Return the darkest spots, darkest first. @param {Plane} dark @returns {Spot[]} */
function spots(dark) {
  const { width } = dark;
  const total = sums(dark, 2);
  const rank = sums(total, 1); // a wide dot is flat: smoothed again, it has a middle
  const highest = extremes(rank, 3).values;
  const top = rank.values.map((value, at) => +(value === highest[at] && total.values[at] >= FAINTEST * 25));
  const found = groups(top, edges(width)).map((group) => {
    const x = Math.floor(mean(group.map((at) => at % width)));
    const y = Math.floor(mean(group.map((at) => Math.floor(at / width))));
    return { x, y, depth: Math.floor(total.values[y * width + x] / 25) };
  });
  return found.sort((a, b) => b.depth - a.depth).slice(0, MOST);
}

/** Return the two steps [x, y] that most pairs of points share, or null. @param {Spot[]} points @param {Plane} dark */
function commonSteps(points, { width, height }) {
  const reach = Math.trunc(LONGEST * Math.min(width, height));
  const middle = reach + 3; // of the planes below, where the step is zero; sums reach 3 beyond
  const side = 2 * middle + 1;
  const counts = plane(side, side, () => 0);
  for (const a of points) {
    for (const b of points) {
      const [x, y] = [a.x - b.x + middle, a.y - b.y + middle];
      if (Math.min(x, y) >= 0 && Math.max(x, y) < side) counts.values[y * side + x]++;
    }
  }
  const votes = sums(sums(counts, 2), 1).values;
  const score = plane(side, side, (column, row, at) => {
    const [x, y] = [Math.abs(column - middle), Math.abs(row - middle)];
    if (Math.max(x, y) > reach || x * x + y * y < SHORTEST ** 2) return 0;
    return votes[at] / (9 * ((1 - y / height) * (1 - x / width) * points.length));
  });
  const highest = extremes(score, 4).values;
  const best = Math.max(...highest);
  if (best < SUPPORT) return null;
  /** @type {{ value: number, step: number[] }[]} */
  const steps = [];
  score.values.forEach((value, at) => {
    const step = [(at % side) - middle, Math.floor(at / side) - middle];
    if (value >= 0.5 * best && value === highest[at]) steps.push({ value, step });
  });
  steps.sort((a, b) => dot(a.step, a.step) - dot(b.step, b.step));
  const first = steps.find(({ value }) => value >= 0.7 * best)?.step ?? [0, 0];
  const turned = [-first[1], first[0]];
  const second = steps.find(({ step }) => Math.abs(dot(turned, step)) > 0.75 * (norm(first) * norm(step)))?.step;
  if (!second) return null;
  const leans = (/** @type {number[]} */ [x, y]) => Math.min(Math.abs(x / y), Math.abs(y / x)) > 0.36;
  const share = (norm(first) * norm(second)) / dot(first, first);
  return share >= 0.6 && share <= 1.8 && !(leans(first) && leans(second)) ? [first, second] : null;
}

/** For each point, its neighbour one step forth and back along both steps (-1: none), and whether none is missing:
 * it is there, or does not fit in. @param {Spot[]} points @param {number[][]} steps @param {Plane} dark */
function neighbours(points, steps, { width, height }) {
  const limit = STRAY ** 2 * dot(steps[0], steps[0]);
  /** The distance of point `j`, squared, from a place beside point `i`; and the point nearest to that place.
   * @param {number} i @param {number} j @param {number[]} step */
  const away = (i, j, [dx, dy]) => (points[j].x - points[i].x - dx) ** 2 + (points[j].y - points[i].y - dy) ** 2;
  const nearest = (/** @type {number} */ i, /** @type {number[]} */ step) =>
    points.reduce((best, _, j) => (away(i, j, step) < away(i, best, step) ? j : best), 0);
  const links = steps.flatMap((step) => {
    const back = step.map((length) => -length);
    const forth = points.map((_, i) => {
      const j = nearest(i, step);
      return nearest(j, back) === i && away(i, j, step) <= limit ? j : -1;
    });
    return [forth, points.map((_, i) => forth.indexOf(i))];
  });
  const inside = (/** @type {number} */ at, /** @type {number} */ length) => at > 3 && at < length - 4;
  const fitting = links.map((of, k) => {
    const [dx, dy] = steps[k >> 1].map((step) => (k % 2 ? -step : step));
    return points.map(({ x, y }, i) => of[i] >= 0 || !inside(x + dx, width) || !inside(y + dy, height));
  });
  return { links, fitting };
}

/** Return the grid that spots form, or null. @param {Plane} dark @param {Spot[]} points @returns {Grid | null} */
function gridOf(dark, points) {
  const steps = commonSteps(points, dark);
  if (!steps) return null;
  const { links, fitting } = neighbours(points, steps, dark);
  const linked = (/** @type {number} */ i) => links.map((of) => of[i]).filter((j) => j >= 0);
  const good = points.map(
    (_, i) => (fitting[0][i] || fitting[1][i]) && (fitting[2][i] || fitting[3][i]) && linked(i).length > 0,
  );
  const [group = []] = groups(good, linked).sort((a, b) => b.length - a.length || Math.max(...a) - Math.max(...b));
  if (group.length < NODES) return null;
  const node = points.map((_, i) => group.includes(i));
  const own = points.filter((_, i) => node[i]);
  const typical = median(own.map(({ depth }) => depth));
  const there = sum(fitting.map((of) => group.filter((i) => of[i]).length)) / (4 * own.length);
  const others = points.filter(({ depth }, i) => depth >= 0.6 * typical && !node[i]).length;
  const reach = (/** @type {number[]} */ all) => Math.max(...all) - Math.min(...all);
  const across = Math.min(reach(own.map(({ x }) => x)) / dark.width, reach(own.map(({ y }) => y)) / dark.height);
  if (there < 0.8 || others > own.length || across < 0.65) return null;
  if (between(dark, own, steps) > 0.42 * typical) return null;
  const exact = [links[0], links[2]].map((forth) => {
    const pairs = group.filter((i) => forth[i] >= 0).map((i) => [points[i], points[forth[i]]]);
    return [median(pairs.map(([p, q]) => q.x - p.x)), median(pairs.map(([p, q]) => q.y - p.y))];
  });
  // a dot at the rim or beside strong relief may lack neighbours; one of them is a node
  const nodes = points.filter(({ depth }, i) => node[i] || (depth >= 0.4 * typical && linked(i).some((j) => node[j])));
  return { nodes, steps: exact, darkness: typical / 255 };
}

/** Return the median darkness halfway between nodes.
 * @param {Plane} dark @param {Spot[]} nodes @param {number[][]} steps */
function between(dark, nodes, [a, b]) {
  const { width, height } = dark;
  const halves = [a, b, [a[0] + b[0], a[1] + b[1]]].map((step) => step.map((length) => Math.floor(length / 2)));
  const places = halves.flatMap(([dx, dy]) => nodes.map(({ x, y }) => [x + dx, y + dy]));
  const inside = places.filter(([x, y]) => x > 0 && y > 0 && x < width - 1 && y < height - 1);
  return median(inside.map(([x, y]) => Math.floor(sumOf(dark, x - 1, y - 1, 3) / 9)));
}

/** Return the grid of the printed dots, or null without one. @param {Plane} brightest @returns {Grid | null} */
function findGrid(brightest) {
  const scale = reduction(brightest);
  const dark = darkness(reduced(brightest, scale));
  const points = spots(dark);
  if (points.length < NODES) return null;
  const whole = (/** @type {number} */ place) => place * scale + (scale >> 1);
  for (const share of FAINT) {
    const kept = points.filter(({ depth }) => depth >= share * points[NODES - 1].depth);
    const grid = gridOf(dark, kept);
    if (!grid) continue;
    const nodes = grid.nodes.map(({ x, y, depth }) => ({ x: whole(x), y: whole(y), depth }));
    return { ...grid, nodes, steps: grid.steps.map((step) => step.map((length) => length * scale)) };
  }
  return null;
}

/** Return which pixels are dots of the grid. @param {Plane} brightest @param {Grid} grid */
function dotted(brightest, { nodes, steps, darkness: typical }) {
  const { width, height } = brightest;
  const dark = darkness(brightest).values;
  const reach = Math.trunc(0.45 * Math.min(...steps.map(norm)));
  const middle = Math.max(1, reach >> 2);
  /** @param {Spot} node @param {number} most */
  const near = ({ x, y }, most) => {
    const all = [];
    for (let j = Math.max(0, y - most); j <= Math.min(height - 1, y + most); j++)
      for (let i = Math.max(0, x - most); i <= Math.min(width - 1, x + most); i++)
        if ((i - x) ** 2 + (j - y) ** 2 <= reach ** 2) all.push(j * width + i);
    return all;
  };
  const [inky, core] = [new Uint8Array(width * height), new Uint8Array(width * height)];
  for (const node of nodes) {
    const inner = near(node, middle);
    const depth = Math.max(...inner.map((at) => dark[at]));
    const least = Math.max(0.35 * depth, 64 * typical);
    for (const at of near(node, reach)) if (dark[at] >= least) inky[at] = 1;
    for (const at of inner) core[at] = 1;
  }
  // of what is dark near a node, only what touches its middle belongs to the dot
  const dots = groups(inky, edges(width)).filter((group) => group.some((at) => core[at]));
  const hole = plane(width, height, () => 0);
  for (const at of dots.flat()) hole.values[at] = 1;
  return extremes(hole, reduction(brightest));
}

/** Laplace's equation in the holes of a channel: at half the size, then a few sweeps.
 * @param {Plane} channel @param {Plane} hole @returns {Float32Array} */
function membrane({ width, height, values }, hole) {
  const known = plane(width, height, (_, __, at) => 1 - hole.values[at]);
  const there = plane(width, height, (_, __, at) => known.values[at] * values[at]);
  const [wide, high] = [Math.ceil(width / 2), Math.ceil(height / 2)];
  const weight = plane(wide, high, (x, y) => sumOf(known, 2 * x, 2 * y, 2));
  const half = plane(wide, high, (x, y, at) =>
    Math.fround(sumOf(there, 2 * x, 2 * y, 2) / Math.max(1, weight.values[at])),
  );
  const empty = plane(wide, high, (_, __, at) => +!weight.values[at]);
  const open = empty.values.includes(1) && empty.values.includes(0);
  const coarse = open ? membrane(half, empty) : half.values;
  const out = Float32Array.from(values);
  const here = [...hole.values.keys()].filter((at) => hole.values[at]);
  for (const at of here) out[at] = coarse[(Math.floor(at / width) >> 1) * half.width + ((at % width) >> 1)];
  const beside = edges(width);
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    const next = here.map((at) => sum(beside(at).map((to) => out[to] ?? out[at])) / 4);
    here.forEach((at, i) => (out[at] = next[i]));
  }
  return out;
}

/** Return the picture with its holes filled from their rims, and grain from half a cell of the grid away.
 * @param {Raster} picture @param {Plane} hole @param {number[][]} steps @returns {Raster} */
function filled({ pixels, width, height }, hole, [a, b]) {
  const nearHole = extremes(hole, 1).values;
  const shifts = [a.map((step, i) => (step + b[i]) / 2), a.map((step, i) => (step - b[i]) / 2)].flatMap(([x, y]) =>
    [1, -1].map((sign) => [sign * even(x), sign * even(y)]),
  );
  /** The pixel whose grain another one gets, or 0. @param {number} at */
  const plain = (at) => {
    const places = shifts.map(([right, down]) => [(at % width) + right, Math.floor(at / width) + down]);
    const inside = places.filter(([x, y]) => x > 0 && y > 0 && x < width - 1 && y < height - 1);
    return inside.map(([x, y]) => y * width + x).find((place) => !nearHole[place]) ?? 0;
  };
  const here = [...hole.values.keys()].filter((at) => hole.values[at]);
  const from = here.map(plain);
  const out = Uint8ClampedArray.from(pixels); // it rounds as Python does
  for (let c = 0; c < 3; c++) {
    const channel = plane(width, height, (_, __, at) => pixels[3 * at + c]);
    const smooth = membrane(channel, hole);
    here.forEach((at, i) => {
      const [x, y] = [from[i] % width, Math.floor(from[i] / width)];
      const grain = from[i] && Math.fround(channel.values[from[i]] - Math.fround(sumOf(channel, x - 1, y - 1, 3) / 9));
      out[3 * at + c] = Math.fround(smooth[at] + grain);
    });
  }
  return { pixels: new Uint8Array(out.buffer), width, height };
}

/** Return the picture without its printed dots; without any, the same object. @param {Raster} picture */
export function withoutDots(picture) {
  const { pixels, width, height } = picture;
  if (Math.min(width, height) < SMALLEST) return picture;
  for (const seen of [pixels, pixels.map((value) => 255 - value)]) {
    const brightest = plane(width, height, (_, __, at) => Math.max(seen[3 * at], seen[3 * at + 1], seen[3 * at + 2]));
    const grid = findGrid(brightest);
    if (grid) return filled(picture, dotted(brightest, grid), grid.steps);
  }
  return picture;
}
