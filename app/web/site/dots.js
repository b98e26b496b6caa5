/** Fill the dots that are printed on a gel: `omnivat/data/grid.py` and `dots.py`, with equal results. No DOM here. */

import { mean } from "./tensors.js";

/** The numbers of the library; tests/web/dots.test.js compares them. */
export const RULES = {
  ...{ SMALLEST: 64, SIDE: 224, WIDEST: 0.085, LONGEST: 0.28, SHORTEST: 11, MOST: 256 },
  ...{ FAINTEST: 26, NODES: 16, SUPPORT: 0.22, STRAY: 0.24, FAINT: [0.35, 0.7] },
};
const { SMALLEST, SIDE, WIDEST, LONGEST, SHORTEST, MOST, FAINTEST, NODES, SUPPORT, STRAY, FAINT } = RULES;

const median = (values) => {
  const sorted = Float64Array.from(values).sort();
  const half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
};
const even = (x) => (Math.abs(x % 1) === 0.5 ? 2 * Math.round(x / 2) : Math.round(x)); // as Python rounds
const clamped = (x, most) => Math.min(Math.max(x, 0), most);
/** A plane of numbers: values, width, height. */
const plane = (width, height, values) => ({ width, height, values: values ?? new Float64Array(width * height) });

/** Each value from those up to `size >> 1` pixels away along one axis; the edge repeats. */
function along({ width, height, values }, size, fold, [length, step, lines, line]) {
  const out = plane(width, height);
  const reach = size >> 1;
  for (let l = 0; l < lines; l++) {
    for (let at = 0; at < length; at++) {
      let sum = values[l * line + clamped(at - reach, length - 1) * step];
      for (let by = 1 - reach; by <= reach; by++)
        sum = fold(sum, values[l * line + clamped(at + by, length - 1) * step]);
      out.values[l * line + at * step] = sum;
    }
  }
  return out;
}

/** The fold of the square of `size` (odd) pixels around each pixel. */
function square(one, size, fold) {
  const { width, height } = one;
  return along(along(one, size, fold, [height, width, width, 1]), size, fold, [width, 1, height, width]);
}
const largest = (a, b) => Math.max(a, b);
const smallest = (a, b) => Math.min(a, b);
const added = (a, b) => a + b;

const reduction = ({ width, height }) => Math.max(1, even(Math.min(width, height) / SIDE));

function reduced({ width, height, values }, scale) {
  const out = plane(Math.floor(width / scale), Math.floor(height / scale));
  for (let y = 0; y < out.height * scale; y++)
    for (let x = 0; x < out.width * scale; x++)
      out.values[Math.floor(y / scale) * out.width + Math.floor(x / scale)] += values[y * width + x];
  out.values = out.values.map((sum) => Math.floor(sum / scale ** 2));
  return out;
}

function darkness(brightest) {
  const { width, height, values } = brightest;
  const widest = Math.floor((WIDEST * Math.min(width, height)) / 2) * 2 + 1;
  const closed = square(square(brightest, widest, largest), widest, smallest);
  closed.values = closed.values.map((c, i) => Math.floor(((c - values[i]) * 255) / Math.max(c, 24)));
  return closed;
}

/** Groups of pixels that are true and share edges: the name of each pixel's group, 0 for none, and how many there
 * are. */
function groups({ width }, is) {
  const names = new Int32Array(is.length);
  let number = 0;
  for (let from = 0; from < names.length; from++) {
    if (names[from] || !is[from]) continue;
    names[from] = ++number;
    for (const stack = [from]; stack.length; ) {
      const at = /** @type {number} */ (stack.pop());
      const x = at % width;
      for (const to of [at - width, at + width, x ? at - 1 : -1, x < width - 1 ? at + 1 : -1]) {
        if (names[to] || !is[to]) continue; // outside, both are undefined
        names[to] = number;
        stack.push(to);
      }
    }
  }
  return { names, number };
}

/** The darkest spots [{x, y, depth}], darkest first. */
function spots(dark) {
  const { width } = dark;
  const total = square(dark, 5, added);
  const rank = square(total, 3, added);
  const highest = square(rank, 7, largest).values;
  const top = rank.values.map((v, i) => +(v === highest[i] && total.values[i] >= FAINTEST * 25));
  const { names, number } = groups(dark, top);
  const sums = Array.from({ length: number + 1 }, () => [0, 0, 0]);
  names.forEach((name, at) => {
    const sum = sums[name];
    sum[0] += at % width;
    sum[1] += Math.floor(at / width);
    sum[2]++;
  });
  return sums
    .slice(1)
    .map(([x, y, count]) => [Math.floor(x / count), Math.floor(y / count)])
    .map(([x, y]) => ({ x, y, depth: Math.floor(total.values[y * width + x] / 25) }))
    .sort((a, b) => b.depth - a.depth)
    .slice(0, MOST);
}

/** The two steps [x, y] that most pairs of points share, or null. */
function commonSteps(points, { width, height }) {
  const reach = Math.trunc(LONGEST * Math.min(width, height));
  const wide = 2 * reach + 7;
  let votes = plane(wide, wide);
  for (const a of points) {
    for (const b of points) {
      const [x, y] = [a.x - b.x + reach + 3, a.y - b.y + reach + 3];
      if (x >= 0 && y >= 0 && x < wide && y < wide) votes.values[y * wide + x]++;
    }
  }
  votes = square(square(votes, 5, added), 3, added);
  const side = 2 * reach + 1;
  const score = plane(side, side);
  for (let y = -reach; y <= reach; y++) {
    for (let x = -reach; x <= reach; x++) {
      const possible = (1 - Math.abs(y) / height) * (1 - Math.abs(x) / width) * points.length;
      const near = x * x + y * y < SHORTEST ** 2;
      const vote = votes.values[(y + reach + 3) * wide + x + reach + 3];
      score.values[(y + reach) * side + x + reach] = near ? 0 : vote / (9 * possible);
    }
  }
  const best = score.values.reduce(largest, 0);
  if (best < SUPPORT) return null;
  const highest = square(score, 9, largest).values;
  const steps = [];
  score.values.forEach((value, at) => {
    if (value < 0.5 * best || value !== highest[at]) return;
    steps.push({ value, step: [(at % side) - reach, Math.floor(at / side) - reach] });
  });
  const length = ({ step: [x, y] }) => x * x + y * y;
  steps.sort((a, b) => length(a) - length(b));
  const first = steps.find(({ value }) => value >= 0.7 * best);
  for (const second of steps) {
    const [[a, b], [c, d]] = [first.step, second.step];
    const lengths = Math.sqrt(length(first)) * Math.sqrt(length(second));
    if (Math.abs(a * d - b * c) <= 0.75 * lengths) continue;
    const leaning = ({ step }) => {
      const [low, high] = step.map(Math.abs).sort((p, q) => p - q);
      return low > 0.36 * high;
    };
    const like = 0.6 * length(first) <= lengths && lengths <= 1.8 * length(first);
    return like && !(leaning(first) && leaning(second)) ? [first.step, second.step] : null;
  }
  return null;
}

/** For each point, its neighbour one step forth and back along both steps (-1: none), and whether each fits in. */
function neighbours(points, steps, { width, height }) {
  const limit = STRAY ** 2 * (steps[0][0] ** 2 + steps[0][1] ** 2);
  const links = [];
  const places = [];
  for (const [dx, dy] of steps) {
    const away = (i, j) => (points[j].x - points[i].x - dx) ** 2 + (points[j].y - points[i].y - dy) ** 2;
    const nearest = (of) =>
      points.map((_, i) => points.reduce((best, __, j) => (of(i, j) < of(i, best) ? j : best), 0));
    const back = nearest((j, i) => away(i, j));
    const forth = nearest(away).map((j, i) => (back[j] === i && away(i, j) <= limit ? j : -1));
    const behind = points.map(() => -1);
    forth.forEach((j, i) => j >= 0 && (behind[j] = i));
    links.push(forth, behind);
    for (const sign of [1, -1]) {
      const inside = (at, side) => at > 3 && at < side - 4;
      places.push(points.map(({ x, y }) => inside(x + sign * dx, width) && inside(y + sign * dy, height)));
    }
  }
  return { links, places };
}

/** The grid that spots form: {nodes, steps, darkness}, or null. */
function gridOf(dark, points) {
  const { width, height } = dark;
  const steps = commonSteps(points, dark);
  if (!steps) return null;
  const { links, places } = neighbours(points, steps, dark);
  const free = (k, i) => links[k][i] >= 0 || !places[k][i];
  const good = points.map(
    (_, i) => (free(0, i) || free(1, i)) && (free(2, i) || free(3, i)) && links.some((of) => of[i] >= 0),
  );
  let names = good.map((is, i) => (is ? i : -1));
  const widened = (all) =>
    all.map((name, i) => (good[i] ? Math.max(name, ...links.map((of) => (of[i] >= 0 ? all[of[i]] : -1))) : -1));
  for (let before = ""; before !== String(names); names = widened(names)) before = String(names);
  const sizes = new Map();
  for (const name of names) if (name >= 0) sizes.set(name, (sizes.get(name) ?? 0) + 1);
  const [group] = [...sizes].sort(([a, m], [b, n]) => n - m || a - b)[0] ?? [-2];
  const node = names.map((name) => name === group);
  const own = points.filter((_, i) => node[i]);
  if (own.length < NODES) return null;
  const depths = own.map(({ depth }) => depth);
  const typical = median(depths);
  const there = links.reduce((sum, _, k) => sum + points.filter((__, i) => node[i] && free(k, i)).length, 0);
  const share = there / (4 * own.length);
  const middle = mean(depths);
  const spread = Math.sqrt(mean(depths.map((depth) => (depth - middle) ** 2)));
  const others = points.filter(({ depth }, i) => depth >= 0.6 * typical && !node[i]).length;
  const reach = (axis) => Math.max(...own.map((p) => p[axis])) - Math.min(...own.map((p) => p[axis]));
  if (share < 0.8 || spread > 0.45 * typical || others > own.length) return null;
  if (Math.min(reach("x") / width, reach("y") / height) < 0.65) return null;
  if (between(dark, own, /** @type {[any, any]} */ (steps)) > 0.42 * typical) return null;
  const exact = [0, 2].map((k) => {
    const linked = points.map((p, i) => [p, points[links[k][i]], node[i]]).filter(([, q, is]) => q && is);
    return ["x", "y"].map((axis) => median(linked.map(([p, q]) => q[axis] - p[axis])));
  });
  const beside = (i) => links.some((of) => of[i] >= 0 && node[of[i]]) && points[i].depth >= 0.4 * typical;
  const nodes = points.filter((_, i) => node[i] || beside(i));
  return { nodes, steps: exact, darkness: typical / 255 };
}

/** The median darkness halfway between nodes. */
function between({ width, height, values }, nodes, [a, b]) {
  const half = (step) => step.map((s) => Math.floor(s / 2));
  const means = [];
  for (const [dx, dy] of [half(a), half(b), half([a[0] + b[0], a[1] + b[1]])]) {
    for (const node of nodes) {
      const [x, y] = [node.x + dx, node.y + dy];
      if (!(x > 0 && y > 0 && x < width - 1 && y < height - 1)) continue;
      let sum = 0;
      for (let j = -1; j < 2; j++) for (let i = -1; i < 2; i++) sum += values[(y + j) * width + x + i];
      means.push(Math.floor(sum / 9));
    }
  }
  return median(means);
}

function findGrid(brightest) {
  const scale = reduction(brightest);
  const dark = darkness(reduced(brightest, scale));
  const points = spots(dark);
  if (points.length < NODES) return null;
  const level = points[NODES - 1].depth;
  for (const share of FAINT) {
    const kept = points.filter(({ depth }) => depth >= share * level);
    const grid = gridOf(dark, kept);
    if (!grid) continue;
    const half = Math.floor(scale / 2);
    const nodes = grid.nodes.map(({ x, y }) => ({ x: x * scale + half, y: y * scale + half }));
    return { ...grid, nodes, steps: grid.steps.map((step) => step.map((s) => s * scale)) };
  }
  return null;
}

/** Which pixels are dots of the grid. */
function dotted(brightest, grid) {
  const { width, height } = brightest;
  const dark = darkness(brightest).values;
  const reach = Math.trunc(0.45 * Math.min(...grid.steps.map(([x, y]) => Math.hypot(x, y))));
  const middle = Math.max(1, reach >> 2);
  const near = ({ x, y }, most, use) => {
    for (let j = Math.max(0, y - most); j <= Math.min(height - 1, y + most); j++)
      for (let i = Math.max(0, x - most); i <= Math.min(width - 1, x + most); i++)
        if ((i - x) ** 2 + (j - y) ** 2 <= reach ** 2) use(j * width + i);
  };
  const inky = new Uint8Array(width * height);
  for (const node of grid.nodes) {
    let depth = 0;
    near(node, middle, (at) => (depth = Math.max(depth, dark[at])));
    const least = Math.max(0.35 * depth, 64 * grid.darkness);
    near(node, reach, (at) => (inky[at] ||= +(dark[at] >= least)));
  }
  const { names } = groups(brightest, inky);
  const dots = new Set();
  for (const node of grid.nodes) near(node, middle, (at) => names[at] && dots.add(names[at]));
  const inside = Float64Array.from(names, (name) => +dots.has(name));
  return square(plane(width, height, inside), 2 * reduction(brightest) + 1, largest);
}

/** Laplace's equation in the holes of a picture: at half the size, then a few sweeps. */
function membrane(values, { width, height, values: hole }, sweeps = 2) {
  const [wide, high] = [Math.ceil(width / 2), Math.ceil(height / 2)];
  const half = new Float32Array(3 * wide * high);
  const empty = plane(wide, high);
  for (let y = 0; y < high; y++) {
    for (let x = 0; x < wide; x++) {
      const to = y * wide + x;
      const block = [0, 1, width, width + 1].filter(
        (by) => 2 * x + (by % width) < width && 2 * y + (by >= width ? 1 : 0) < height,
      );
      const known = block.map((by) => 2 * y * width + 2 * x + by).filter((at) => !hole[at]);
      empty.values[to] = +!known.length;
      for (let c = 0; c < 3; c++)
        half[3 * to + c] = known.reduce((sum, at) => sum + values[3 * at + c], 0) / Math.max(1, known.length);
    }
  }
  const holes = empty.values.reduce(added, 0);
  const coarse = holes && holes < wide * high ? membrane(half, empty) : half;
  const out = Float32Array.from(values);
  const here = [];
  hole.forEach((is, at) => {
    if (!is) return;
    const [x, y] = [at % width, Math.floor(at / width)];
    here.push([at, at - width * +(y > 0), at + width * +(y < height - 1), at - +(x > 0), at + +(x < width - 1)]);
    for (let c = 0; c < 3; c++) out[3 * at + c] = coarse[3 * ((y >> 1) * wide + (x >> 1)) + c];
  });
  const next = new Float32Array(3 * here.length);
  for (let sweep = 0; sweep < sweeps; sweep++) {
    here.forEach(([, up, down, left, right], i) => {
      for (let c = 0; c < 3; c++)
        next[3 * i + c] = (out[3 * up + c] + out[3 * down + c] + out[3 * left + c] + out[3 * right + c]) / 4;
    });
    here.forEach(([at], i) => out.set(next.subarray(3 * i, 3 * i + 3), 3 * at));
  }
  return out;
}

/** The picture with its holes filled from their rims, and grain from half a cell of the grid away. */
function filled({ pixels, width, height }, hole, [a, b]) {
  const smooth = membrane(pixels, hole);
  const nearHole = square(hole, 3, largest).values;
  const shifts = [a.map((s, i) => (s + b[i]) / 2), a.map((s, i) => (s - b[i]) / 2)].flatMap(([x, y]) =>
    [1, -1].map((sign) => [sign * even(x), sign * even(y)]),
  );
  const out = Uint8ClampedArray.from(pixels);
  hole.values.forEach((is, at) => {
    if (!is) return;
    const [x, y] = [at % width, Math.floor(at / width)];
    const from = shifts
      .map(([right, down]) => [x + right, y + down])
      .find(([i, j]) => i > 0 && j > 0 && i < width - 1 && j < height - 1 && !nearHole[j * width + i]);
    for (let c = 0; c < 3; c++) {
      let grain = 0;
      if (from) {
        const place = 3 * (from[1] * width + from[0]) + c;
        let around = 0;
        for (let j = -1; j < 2; j++) for (let i = -1; i < 2; i++) around += pixels[place + 3 * (j * width + i)];
        grain = Math.fround(pixels[place] - Math.fround(around / 9));
      }
      out[3 * at + c] = even(Math.fround(smooth[3 * at + c] + grain));
    }
  });
  return { pixels: new Uint8Array(out.buffer), width, height };
}

/** The picture {pixels, width, height} without its printed dots; without any, the same object. */
export function withoutDots(picture) {
  const { pixels, width, height } = picture;
  if (Math.min(width, height) < SMALLEST) return picture;
  for (const light of [false, true]) {
    const brightest = plane(width, height);
    for (let at = 0; at < width * height; at++) {
      const [r, g, b] = pixels.subarray(3 * at, 3 * at + 3);
      brightest.values[at] = light ? 255 - Math.min(r, g, b) : Math.max(r, g, b);
    }
    const grid = findGrid(brightest);
    if (grid) return filled(picture, dotted(brightest, grid), /** @type {[any, any]} */ (grid.steps));
  }
  return picture;
}
