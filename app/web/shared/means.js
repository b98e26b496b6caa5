/** The gaps, drawn: the means of each group's VIS and TAC points, and the line between them. */

import { COLOURINGS, isDark } from "./palette.js";
import { state } from "./store.js";

const ALL = { of: () => () => 0, groups: () => [["all pairs", null]] };
const SIZE = 8; // CSS pixels, less on a small map

/** A painter: one line for each domain or class, or one for all, over points with `shown(point)`. */
export function means(frames, shown) {
  return (context, cloud) => {
    if (state.means !== "1") return;
    const grouping = ["domain", "class"].includes(state.colour) ? COLOURINGS[state.colour] : ALL;
    const groups = grouping.groups(frames());
    const of = grouping.of(frames());
    const pairs = cloud.count / 2;
    const sums = new Float64Array(groups.length * 6); // x, y, count of VIS, then of TAC
    for (let point = 0; point < cloud.count; point++) {
      if (!shown(point)) continue;
      const tac = point >= pairs;
      const at = 6 * of(tac ? point - pairs : point) + (tac ? 3 : 0);
      sums[at] += cloud.x[point];
      sums[at + 1] += cloud.y[point];
      sums[at + 2] += 1;
    }
    const edge = isDark() ? "#0b1220" : "#ffffff";
    const places = groups.map(([, colour], i) => {
      const mean = (at) =>
        sums[at + 2] && [sums[at] / sums[at + 2] / cloud.ratio, sums[at + 1] / sums[at + 2] / cloud.ratio];
      return { colour: colour ?? (isDark() ? "#f8fafc" : "#0f172a"), vis: mean(6 * i), tac: mean(6 * i + 3) };
    });
    for (const [width, stroke] of /** @type {[number, (p: any) => string][]} */ ([
      [7, () => edge],
      [3.4, (p) => p.colour],
    ])) {
      for (const place of places)
        if (place.vis && place.tac) line(context, place.vis, place.tac, width, stroke(place));
    }
    const size = cloud.width / cloud.ratio < 260 ? 0.7 * SIZE : SIZE;
    for (const { colour, vis, tac } of places) {
      if (vis) shape(context, colour, edge, () => context.arc(...vis, size, 0, 7));
      if (tac) shape(context, colour, edge, () => triangle(context, ...tac, size));
    }
    const source = grouping.groups(frames()).findIndex(([name]) => name === frames().source);
    if (source < 0 || state.colour !== "domain") return;
    const marks = places.flatMap(({ vis, tac }) => [vis, tac]).filter(Boolean);
    label(context, cloud, places[source], marks, edge);
  };
}

/** Label the source at its VIS and TAC means. */
function label(context, cloud, { vis, tac, colour }, marks, edge) {
  context.font = "700 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.lineWidth = 4;
  context.lineJoin = "round";
  const view = [cloud.width / cloud.ratio, cloud.height / cloud.ratio];
  const wide = context.measureText("source").width;
  for (const [x, y] of labelPlaces([vis, tac].filter(Boolean), marks, wide, view)) {
    context.strokeStyle = edge;
    context.strokeText("source", x, y);
    context.fillStyle = colour;
    context.fillText("source", x, y);
  }
}

const HIGH = 12; // CSS pixels of a label's letters
const AXIS = [0, 0, 165, 22]; // the name of the vertical axis
const SIDES = [
  [0, -1],
  [0, 1],
  [1, 0],
  [-1, 0],
  [1, -1],
  [-1, -1],
  [1, 1],
  [-1, 1],
]; // above first

/**
 * Where a label of `wide` pixels stands beside each point: middle of its baseline. It covers as
 * little as possible of the marks, the axis name and other labels, and stays inside the view. Of two
 * points closer than a label, only the first has one.
 * @param {number[][]} points @param {number[][]} marks @param {number} wide @param {number[]} view
 */
export function labelPlaces(points, marks, wide, [width, height]) {
  const far = points.filter(([x, y], i) => !i || Math.hypot(x - points[0][0], y - points[0][1]) > wide);
  const taken = [AXIS, ...marks.map(([x, y]) => [x - SIZE - 2, y - SIZE - 2, x + SIZE + 2, y + SIZE + 2])];
  return far.map(([x, y]) => {
    const boxes = SIDES.map(([across, down]) => {
      const [cx, cy] = [x + across * (wide / 2 + SIZE + 5), y + down * (HIGH / 2 + SIZE + 3)];
      return [cx - wide / 2, cy - HIGH / 2, cx + wide / 2, cy + HIGH / 2];
    });
    const costs = boxes.map(
      (box) =>
        taken.reduce((sum, other) => sum + overlap(box, other), 0) +
        (box[0] < 2 || box[1] < 2 || box[2] > width - 2 || box[3] > height - 2 ? 1e6 : 0),
    );
    const best = boxes[costs.indexOf(Math.min(...costs))];
    taken.push(best);
    return [(best[0] + best[2]) / 2, best[3] - 2];
  });
}

const overlap = (a, b) =>
  Math.max(0, Math.min(a[2], b[2]) - Math.max(a[0], b[0])) *
  Math.max(0, Math.min(a[3], b[3]) - Math.max(a[1], b[1]));

function line(context, a, b, width, colour) {
  context.beginPath();
  context.moveTo(...a);
  context.lineTo(...b);
  context.lineWidth = width;
  context.lineCap = "round";
  context.strokeStyle = colour;
  context.stroke();
}

function triangle(context, x, y, size) {
  context.moveTo(x, y - 1.2 * size);
  context.lineTo(x + 1.15 * size, y + 0.85 * size);
  context.lineTo(x - 1.15 * size, y + 0.85 * size);
  context.closePath();
}

function shape(context, colour, edge, outline) {
  for (const [width, stroke] of [
    [6.5, edge],
    [2, "#0f172a"],
  ]) {
    context.beginPath();
    outline();
    context.lineWidth = width;
    context.strokeStyle = stroke;
    context.stroke();
  }
  context.fillStyle = colour;
  context.fill();
}
