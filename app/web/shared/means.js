/** Groups of points on the map: their names, and the gaps between their VIS and TAC means. */

import { segment, stroked } from "./canvas.js";
import { mean } from "./numbers.js";
import { colouring, isDark, isLecture } from "./palette.js";
import { SHAPES } from "./points.js";
import { state } from "./store.js";
import { sensorOf } from "./tables.js";

/** @typedef {CanvasRenderingContext2D} Context @typedef {import("./cloud.js").Cloud} Cloud */
/** @typedef {{name: string, colour: string, vis: Point | null, tac: Point | null, both: Point | null}} Group */
/** @typedef {{text: string, colour: string, x: number, y: number, wide: number}} Label */

const SIZE = 8; // CSS pixels, less on a small map
const HIGH = 22; // CSS pixels of a name
const MOST = 8000; // points that names look at
const NEAR = 0.08; // of the map's longer side: how near points of a crowd are
const CROWD = 1.6; // times the points at the mean
const TRIES = 16; // points of a group whose surroundings are counted
const STEP = 6; // by which a name moves aside

const inkOf = () => (isDark() ? "#f8fafc" : "#0f172a");

/** Return the groups of a colouring by values of the pairs, or all points as one, and their means in CSS pixels: of
 * VIS, of TAC, of both.
 * @param {Frames} frames @param {Cloud} cloud @param {(point: number) => boolean} shown
 * @param {Pick<Colouring, "values" | "groups" | "of">} chosen
 * @returns {Group[]} */
export function groupsOf(frames, cloud, shown, chosen) {
  /** @type {[string, string][]} */
  const groups = chosen.values ? chosen.groups(frames) : [["", inkOf()]];
  const of = chosen.values ? chosen.of(frames, 0) : () => 0;
  const sums = groups.map(() => [0, 0, 0, 0, 0, 0]); // x, y, count of VIS, then of TAC
  for (let point = 0; point < cloud.count; point++) {
    if (!shown(point)) continue;
    const tac = point >= frames.pairs ? 3 : 0;
    const sum = sums[of(point % frames.pairs)];
    sum[tac] += cloud.x[point];
    sum[tac + 1] += cloud.y[point];
    sum[tac + 2] += 1;
  }
  /** @param {number[]} sum @returns {Point | null} */
  const mean = ([x, y, count]) => (count ? [x / count, y / count] : null);
  return groups.map(([name, colour], i) => {
    const [vis, tac] = [sums[i].slice(0, 3), sums[i].slice(3)];
    return { name, colour, vis: mean(vis), tac: mean(tac), both: mean(vis.map((v, k) => v + tac[k])) };
  });
}

/** Return a painter: one line for each group of pairs, or one for all, over points with `shown(point)`.
 * @param {() => Frames} frames @param {(point: number) => boolean} shown @returns {Painter} */
export function means(frames, shown) {
  return (context, cloud) => {
    if (state.means !== "1") return;
    const edge = isDark() ? "#0b1220" : "#ffffff";
    const groups = groupsOf(frames(), cloud, shown, colouring(frames(), state.colour));
    context.lineCap = "round";
    for (const { vis, tac, colour } of groups)
      if (vis && tac) stroked(context, () => segment(context, vis, tac), [7, edge], [3.4, colour]);
    const size = cloud.width < 260 ? 0.7 * SIZE : SIZE;
    for (const { colour, vis, tac } of groups) {
      context.fillStyle = colour;
      for (const [shape, place] of /** @type {const} */ ([
        ["circle", vis],
        ["triangle", tac],
      ])) {
        if (!place) continue;
        stroked(context, () => SHAPES[shape](context, place, size), [6.5, edge], [2, "#0f172a"]);
        context.fill();
      }
    }
  };
}

/** Return groups with a place {x, y} for their names: where many of their points are. A mean between two clouds has
 * none.
 * @template {Pick<Group, "both">} T @param {T[]} groups @param {(pair: number) => number} of
 * @param {Pick<Cloud, "count" | "width" | "height" | "x" | "y">} cloud @param {(point: number) => boolean} shown */
export function settled(groups, of, cloud, shown) {
  const step = Math.ceil(cloud.count / MOST);
  const reach = (NEAR * Math.max(cloud.width, cloud.height)) ** 2;
  /** @type {Point[][]} */
  const members = groups.map(() => []);
  for (let point = 0; point < cloud.count; point += step)
    // no group: for a moment, the points are still those of a larger set before
    if (shown(point)) members[of(point % (cloud.count / 2))]?.push([cloud.x[point], cloud.y[point]]);
  return groups.map((group, i) => {
    /** @param {Point} place */
    const around = ([x, y]) => members[i].filter((member) => (member[0] - x) ** 2 + (member[1] - y) ** 2 < reach);
    let near = group.both ? around(group.both) : [];
    const least = CROWD * near.length; // a name leaves its mean for a far larger crowd only
    const every = Math.ceil(members[i].length / TRIES);
    for (let k = 0; k < members[i].length; k += every) {
      const there = around(members[i][k]);
      if (there.length > Math.max(least, near.length)) near = there;
    }
    const [x, y] = [0, 1].map((axis) => mean(near.map((place) => place[axis])));
    return { ...group, x, y };
  });
}

/** Return a painter: the name of each group of pairs at its points; the source is marked. Where no group has a place of
 * its own, the names stand in a row.
 * @param {() => Frames} frames @param {(point: number) => boolean} shown @returns {Painter} */
export function names(frames, shown) {
  return (context, cloud) => {
    const chosen = colouring(frames(), state.colour);
    const { width, height } = cloud;
    const letters = isLecture() ? 20 : chosen.values && width < 420 ? 12 : 14;
    context.font = `650 ${letters}px system-ui, sans-serif`;
    context.textAlign = "left";
    context.textBaseline = "middle";
    /** A name beside its colour. @param {string} text @param {string} colour @param {number} x @param {number} y */
    const write = (text, colour, x, y, wide = 6) => {
      context.fillStyle = colour;
      context.fillRect(x, y - 5, wide, 10);
      context.fillStyle = inkOf();
      context.fillText(text, x + wide + 4, y + 0.5);
    };
    if (chosen.values) {
      const groups = settled(groupsOf(frames(), cloud, shown, chosen), chosen.of(frames(), 0), cloud, shown);
      const labels = groups.flatMap(({ name, colour, both, x, y }) => {
        if (!both || x < 0 || y < 0 || x > width || y > height) return []; // its points are out of view
        const text = sensorOf(name) + (name === frames().source ? " · source" : "");
        return [{ text, colour, x, y, wide: context.measureText(text).width + 22 }];
      });
      const below = cloud.box.closest(".stage") ? 44 : 0; // Explore's buttons stand there
      const high = Math.round(HIGH * (letters / 14));
      for (const { text, colour, x, y, wide } of apart(labels, [width, height - below], high)) {
        context.beginPath();
        context.roundRect(x - wide / 2, y - high / 2, wide, high, 6);
        context.fillStyle = isDark() ? "rgb(15 23 42 / .82)" : "rgb(255 255 255 / .86)";
        context.fill();
        write(text, colour, x - wide / 2 + 5, y);
      }
    } else {
      let x = 14;
      for (const [name, colour] of chosen.groups(frames())) {
        write(name, colour, x, cloud.top + 18, 10);
        x += 34 + context.measureText(name).width;
      }
    }
    context.textBaseline = "alphabetic";
  };
}

/** Move labels up or down until none covers another and all are within the view. Those higher up come first; one
 * without room is left out. @param {Label[]} labels @param {number[]} view */
export function apart(labels, [width, height], high = HIGH) {
  /** @type {Label[]} */
  const taken = [];
  for (const label of labels.toSorted((a, b) => a.y - b.y)) {
    const x = Math.max(label.wide / 2 + 2, Math.min(width - label.wide / 2 - 2, label.x));
    const ys = Array.from({ length: 80 }, (_, i) => label.y + (i % 2 ? 1 : -1) * Math.ceil(i / 2) * STEP);
    const y = ys.find(
      (y) =>
        y >= high / 2 &&
        y <= height - high / 2 &&
        taken.every((o) => Math.abs(o.x - x) >= (o.wide + label.wide) / 2 || Math.abs(o.y - y) >= high),
    );
    if (y !== undefined) taken.push({ ...label, x, y });
  }
  return taken;
}
