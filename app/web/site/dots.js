/** Fill the dots that are printed on a gel: `omnivat/data/grid.py` and `dots.py`, with equal results. No DOM here. */

import { DOTS } from "./rules.js";
import { dot, mean, sum } from "./tensors.js";

const { SMALLEST, SIDE, WIDEST, LONGEST, SHORTEST, MOST, FAINTEST, NODES, SUPPORT, STRAY, FAINT } = DOTS;
/** @typedef {{ x: number, y: number }} Place @typedef {(a: number, b: number) => number} Fold
 * @typedef {Pick<Plane, "width" | "height">} Size */

/** @param {number[]} values */
const median = (values) => {
  const sorted = Float64Array.from(values).sort();
  const half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
};
/** As Python rounds. @param {number} x */
const even = (x) => (Math.abs(x % 1) === 0.5 ? 2 * Math.round(x / 2) : Math.round(x));
/** @param {number} x @param {number} most */
const clamped = (x, most) => Math.min(Math.max(x, 0), most);
/** @param {number} width @param {number} height @param {Float64Array} [values] @returns {Plane} */
const plane = (width, height, values = new Float64Array(width * height)) => ({ width, height, values });
/** The values of the 3 × 3 pixels around one, `wide` of which are a row. @param {ArrayLike<number>} values
 * @param {number} at @param {number} wide @param {number} step from one value to the next */
function around(values, at, wide, step = 1) {
  let total = 0;
  for (let j = -1; j < 2; j++) for (let i = -1; i < 2; i++) total += values[at + step * (j * wide + i)];
  return total;
}

/** Each value from those up to `size >> 1` pixels away along one axis; the edge repeats.
 * @param {Plane} one @param {number} size @param {Fold} fold @param {number[]} axis @returns {Plane} */
function along({ width, height, values }, size, fold, [length, step, lines, line]) {
  const out = plane(width, height);
  const reach = size >> 1;
  for (let l = 0; l < lines; l++) {
    for (let at = 0; at < length; at++) {
      let folded = values[l * line + clamped(at - reach, length - 1) * step];
      for (let by = 1 - reach; by <= reach; by++)
        folded = fold(folded, values[l * line + clamped(at + by, length - 1) * step]);
      out.values[l * line + at * step] = folded;
    }
  }
  return out;
}

/** The fold of the square of `size` (odd) pixels around each pixel.
 * @param {Plane} one @param {number} size @param {Fold} fold */
function square(one, size, fold) {
  const { width, height } = one;
  return along(along(one, size, fold, [height, width, width, 1]), size, fold, [width, 1, height, width]);
}
/** @type {Fold} */
const largest = (a, b) => Math.max(a, b);
/** @type {Fold} */
const smallest = (a, b) => Math.min(a, b);
/** @type {Fold} */
const added = (a, b) => a + b;

/** @param {Size} size */
const reduction = ({ width, height }) => Math.max(1, even(Math.min(width, height) / SIDE));

/** @param {Plane} one @param {number} scale */
function reduced({ width, height, values }, scale) {
  const out = plane(Math.floor(width / scale), Math.floor(height / scale));
  for (let y = 0; y < out.height * scale; y++)
    for (let x = 0; x < out.width * scale; x++)
      out.values[Math.floor(y / scale) * out.width + Math.floor(x / scale)] += values[y * width + x];
  return plane(
    out.width,
    out.height,
    out.values.map((total) => Math.floor(total / scale ** 2)),
  );
}

/** How dark each pixel is beside what is around it, 0 to 255. @param {Plane} brightest */
function darkness({ width, height, values }) {
  const widest = Math.floor((WIDEST * Math.min(width, height)) / 2) * 2 + 1;
  const closed = square(square(plane(width, height, values), widest, largest), widest, smallest).values;
  const dark = closed.map((c, i) => Math.floor(((c - values[i]) * 255) / Math.max(c, 24)));
  return plane(width, height, dark);
}

/** Groups of pixels that are true and share edges: the name of each pixel's group, 0 for none, and how many there
 * are. @param {Size} size @param {ArrayLike<number>} is */
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

/** The darkest spots, darkest first. @param {Plane} dark @returns {Spot[]} */
function spots(dark) {
  const { width } = dark;
  const total = square(dark, 5, added);
  const rank = square(total, 3, added);
  const highest = square(rank, 7, largest).values;
  const top = rank.values.map((v, i) => +(v === highest[i] && total.values[i] >= FAINTEST * 25));
  const { names, number } = groups(dark, top);
  const sums = Array.from({ length: number + 1 }, () => [0, 0, 0]);
  names.forEach((name, at) => {
    const one = sums[name];
    one[0] += at % width;
    one[1] += Math.floor(at / width);
    one[2]++;
  });
  return sums
    .slice(1)
    .map(([left, down, count]) => {
      const [x, y] = [Math.floor(left / count), Math.floor(down / count)];
      return { x, y, depth: Math.floor(total.values[y * width + x] / 25) };
    })
    .sort((a, b) => b.depth - a.depth)
    .slice(0, MOST);
}

/** The two steps [x, y] that most pairs of points share, or null. @param {Place[]} points @param {Size} size
 * @returns {[Point, Point] | null} */
function commonSteps(points, { width, height }) {
  const reach = Math.trunc(LONGEST * Math.min(width, height));
  const wide = 2 * reach + 7;
  const counts = plane(wide, wide);
  for (const a of points) {
    for (const b of points) {
      const [x, y] = [a.x - b.x + reach + 3, a.y - b.y + reach + 3];
      if (x >= 0 && y >= 0 && x < wide && y < wide) counts.values[y * wide + x]++;
    }
  }
  const votes = square(square(counts, 5, added), 3, added).values;
  const side = 2 * reach + 1;
  const score = plane(side, side);
  for (let y = -reach; y <= reach; y++) {
    for (let x = -reach; x <= reach; x++) {
      const possible = (1 - Math.abs(y) / height) * (1 - Math.abs(x) / width) * points.length;
      const vote = votes[(y + reach + 3) * wide + x + reach + 3];
      score.values[(y + reach) * side + x + reach] = x * x + y * y < SHORTEST ** 2 ? 0 : vote / (9 * possible);
    }
  }
  const best = score.values.reduce(largest, 0);
  if (best < SUPPORT) return null;
  const highest = square(score, 9, largest).values;
  /** @type {{ value: number, step: Point }[]} */
  const steps = [];
  score.values.forEach((value, at) => {
    if (value >= 0.5 * best && value === highest[at])
      steps.push({ value, step: [(at % side) - reach, Math.floor(at / side) - reach] });
  });
  steps.sort((a, b) => dot(a.step, a.step) - dot(b.step, b.step));
  const first = steps.find(({ value }) => value >= 0.7 * best)?.step ?? [0, 0];
  const [a, b] = first;
  const long = dot(first, first);
  const second = steps
    .map(({ step }) => step)
    .find(([c, d]) => Math.abs(a * d - b * c) > 0.75 * (Math.sqrt(long) * Math.sqrt(c * c + d * d)));
  if (!second) return null;
  const lengths = Math.sqrt(long) * Math.sqrt(dot(second, second));
  const leaning = (/** @type {Point} */ step) => {
    const [low, high] = step.map(Math.abs).sort((p, q) => p - q);
    return low > 0.36 * high;
  };
  const like = 0.6 * long <= lengths && lengths <= 1.8 * long;
  return like && !(leaning(first) && leaning(second)) ? [first, second] : null;
}

/** For each point, its neighbour one step forth and back along both steps (-1: none), and whether each fits in.
 * @param {Place[]} points @param {Point[]} steps @param {Size} size */
function neighbours(points, steps, { width, height }) {
  const limit = STRAY ** 2 * dot(steps[0], steps[0]);
  const [links, places] = [/** @type {number[][]} */ ([]), /** @type {boolean[][]} */ ([])];
  for (const [dx, dy] of steps) {
    /** @type {Fold} */
    const away = (i, j) => (points[j].x - points[i].x - dx) ** 2 + (points[j].y - points[i].y - dy) ** 2;
    const nearest = (/** @type {Fold} */ of) =>
      points.map((_, i) => points.reduce((best, __, j) => (of(i, j) < of(i, best) ? j : best), 0));
    const back = nearest((j, i) => away(i, j));
    const forth = nearest(away).map((j, i) => (back[j] === i && away(i, j) <= limit ? j : -1));
    const behind = points.map(() => -1);
    forth.forEach((j, i) => j >= 0 && (behind[j] = i));
    links.push(forth, behind);
    for (const sign of [1, -1]) {
      const inside = (/** @type {number} */ at, /** @type {number} */ side) => at > 3 && at < side - 4;
      places.push(points.map(({ x, y }) => inside(x + sign * dx, width) && inside(y + sign * dy, height)));
    }
  }
  return { links, places };
}

/** Which points belong to the largest group of linked ones among the good. @param {boolean[]} good
 * @param {number[][]} links */
function largestGroup(good, links) {
  let names = good.map((is, i) => (is ? i : -1));
  for (let before = ""; before !== String(names); ) {
    before = String(names);
    const all = names;
    const near = (/** @type {number} */ i) => links.map((of) => (of[i] >= 0 ? all[of[i]] : -1));
    names = all.map((name, i) => (good[i] ? Math.max(name, ...near(i)) : -1));
  }
  const sizes = new Map();
  for (const name of names) if (name >= 0) sizes.set(name, (sizes.get(name) ?? 0) + 1);
  const [group] = [...sizes].sort(([a, m], [b, n]) => n - m || a - b)[0] ?? [-2];
  return names.map((name) => name === group);
}

/** The grid that spots form, or null. @param {Plane} dark @param {Spot[]} points @returns {Grid | null} */
function gridOf(dark, points) {
  const { width, height } = dark;
  const steps = commonSteps(points, dark);
  if (!steps) return null;
  const { links, places } = neighbours(points, steps, dark);
  /** @param {number} k @param {number} i */
  const free = (k, i) => links[k][i] >= 0 || !places[k][i];
  const good = points.map(
    (_, i) => (free(0, i) || free(1, i)) && (free(2, i) || free(3, i)) && links.some((of) => of[i] >= 0),
  );
  const node = largestGroup(good, links);
  const own = points.filter((_, i) => node[i]);
  if (own.length < NODES) return null;
  const depths = own.map(({ depth }) => depth);
  const typical = median(depths);
  const there = sum(links.map((_, k) => points.filter((__, i) => node[i] && free(k, i)).length));
  const middle = mean(depths);
  const spread = Math.sqrt(mean(depths.map((depth) => (depth - middle) ** 2)));
  const others = points.filter(({ depth }, i) => depth >= 0.6 * typical && !node[i]).length;
  const reach = (/** @type {number[]} */ all) => Math.max(...all) - Math.min(...all);
  const across = Math.min(reach(own.map(({ x }) => x)) / width, reach(own.map(({ y }) => y)) / height);
  if (there / (4 * own.length) < 0.8 || spread > 0.45 * typical || others > own.length || across < 0.65) return null;
  if (between(dark, own, steps) > 0.42 * typical) return null;
  const exact = [0, 2].map((k) => {
    const linked = points.flatMap((p, i) => (node[i] && links[k][i] >= 0 ? [[p, points[links[k][i]]]] : []));
    /** @type {Point} */
    const step = [median(linked.map(([p, q]) => q.x - p.x)), median(linked.map(([p, q]) => q.y - p.y))];
    return step;
  });
  const beside = (/** @type {number} */ i) =>
    links.some((of) => of[i] >= 0 && node[of[i]]) && points[i].depth >= 0.4 * typical;
  return { nodes: points.filter((_, i) => node[i] || beside(i)), steps: exact, darkness: typical / 255 };
}

/** The median darkness halfway between nodes. @param {Plane} dark @param {Place[]} nodes @param {Point[]} steps */
function between({ width, height, values }, nodes, [a, b]) {
  const halves = [a, b, [a[0] + b[0], a[1] + b[1]]].map((step) => step.map((s) => Math.floor(s / 2)));
  const places = halves.flatMap(([dx, dy]) => nodes.map(({ x, y }) => [x + dx, y + dy]));
  const inside = places.filter(([x, y]) => x > 0 && y > 0 && x < width - 1 && y < height - 1);
  return median(inside.map(([x, y]) => Math.floor(around(values, y * width + x, width) / 9)));
}

/** @param {Plane} brightest @returns {Grid | null} */
function findGrid(brightest) {
  const scale = reduction(brightest);
  const dark = darkness(reduced(brightest, scale));
  const points = spots(dark);
  if (points.length < NODES) return null;
  for (const share of FAINT) {
    const kept = points.filter(({ depth }) => depth >= share * points[NODES - 1].depth);
    const grid = gridOf(dark, kept);
    if (!grid) continue;
    const half = Math.floor(scale / 2);
    const nodes = grid.nodes.map(({ x, y }) => ({ x: x * scale + half, y: y * scale + half }));
    return { ...grid, nodes, steps: grid.steps.map(([x, y]) => [x * scale, y * scale]) };
  }
  return null;
}

/** Which pixels are dots of the grid. @param {Plane} brightest @param {Grid} grid */
function dotted(brightest, grid) {
  const { width, height } = brightest;
  const dark = darkness(brightest).values;
  const reach = Math.trunc(0.45 * Math.min(...grid.steps.map(([x, y]) => Math.hypot(x, y))));
  const middle = Math.max(1, reach >> 2);
  /** @param {Place} node @param {number} most @param {(at: number) => void} use */
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

/** Laplace's equation in the holes of a picture: at half the size, then a few sweeps.
 * @param {ArrayLike<number>} values @param {Plane} holes @returns {Float32Array} */
function membrane(values, { width, height, values: hole }, sweeps = 2) {
  const [wide, high] = [Math.ceil(width / 2), Math.ceil(height / 2)];
  const half = new Float32Array(3 * wide * high);
  const empty = plane(wide, high);
  for (let to = 0; to < wide * high; to++) {
    const [x, y] = [2 * (to % wide), 2 * Math.floor(to / wide)];
    const known = [0, 1, width, width + 1]
      .filter((by) => x + (by % width) < width && y + (by >= width ? 1 : 0) < height)
      .map((by) => y * width + x + by)
      .filter((at) => !hole[at]);
    empty.values[to] = +!known.length;
    for (let c = 0; c < 3; c++)
      half[3 * to + c] = sum(known.map((at) => values[3 * at + c])) / Math.max(1, known.length);
  }
  const holes = empty.values.reduce(added, 0);
  const coarse = holes && holes < wide * high ? membrane(half, empty) : half;
  const out = Float32Array.from(values);
  /** @type {number[][]} */
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

/** The picture with its holes filled from their rims, and grain from half a cell of the grid away.
 * @param {Raster} picture @param {Plane} hole @param {Point[]} steps @returns {Raster} */
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
      const place = from ? 3 * (from[1] * width + from[0]) + c : 0;
      const grain = from ? Math.fround(pixels[place] - Math.fround(around(pixels, place, width, 3) / 9)) : 0;
      out[3 * at + c] = even(Math.fround(smooth[3 * at + c] + grain));
    }
  });
  return { pixels: new Uint8Array(out.buffer), width, height };
}

/** The picture without its printed dots; without any, the same object. @param {Raster} picture */
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
    if (grid) return filled(picture, dotted(brightest, grid), grid.steps);
  }
  return picture;
}
