/** Groups of points on the map: their names, and the gaps between their VIS and TAC means. */

import { COLOURINGS, colouring, isDark, isLecture } from "./palette.js";
import { state } from "./store.js";

const ALL = { of: () => () => 0, groups: () => [["", null]] };
const SIZE = 8; // CSS pixels, less on a small map
const HIGH = 22; // CSS pixels of a name
const MOST = 8000; // points that names look at
const NEAR = 0.08; // of the map's longer side: how near points of a crowd are
const CROWD = 1.6; // times the points at the mean
const TRIES = 16; // points of a group whose surroundings are counted
const STEP = 6; // by which a name moves aside

/** The groups of the present colouring, and their means in CSS pixels: of VIS, of TAC, of both. */
function groupsOf(frames, cloud, shown, colour) {
  const grouping = ["domain", "class"].includes(colour) ? COLOURINGS[colour] : ALL;
  const groups = grouping.groups(frames);
  const of = grouping.of(frames, 0);
  const pairs = cloud.count / 2;
  const sums = new Float64Array(groups.length * 6); // x, y, count of VIS, then of TAC
  for (let point = 0; point < cloud.count; point++) {
    if (!shown(point)) continue;
    const tac = point >= pairs;
    const at = 6 * of(tac ? point - pairs : point) + (tac ? 3 : 0);
    sums[at] += cloud.x[point] / cloud.ratio;
    sums[at + 1] += cloud.y[point] / cloud.ratio;
    sums[at + 2] += 1;
  }
  return groups.map(([name, colour], i) => {
    const [vis, tac] = [sums.subarray(6 * i, 6 * i + 3), sums.subarray(6 * i + 3, 6 * i + 6)];
    const mean = (s) => s[2] && [s[0] / s[2], s[1] / s[2]];
    return { name, colour, vis: mean(vis), tac: mean(tac), both: mean(vis.map((v, k) => v + tac[k])) };
  });
}

/** A painter: one line for each domain or class, or one for all, over points with `shown(point)`. */
export function means(frames, shown, on = () => state.means === "1") {
  return (context, cloud) => {
    if (!on()) return;
    const edge = isDark() ? "#0b1220" : "#ffffff";
    const ink = isDark() ? "#f8fafc" : "#0f172a";
    const places = groupsOf(frames(), cloud, shown, state.colour);
    for (const [width, stroke] of /** @type {[number, (p: any) => string][]} */ ([
      [7, () => edge],
      [3.4, (p) => p.colour ?? ink],
    ])) {
      for (const place of places) if (place.vis && place.tac) line(context, place.vis, place.tac, width, stroke(place));
    }
    const size = cloud.width / cloud.ratio < 260 ? 0.7 * SIZE : SIZE;
    for (const { colour, vis, tac } of places) {
      if (vis) shape(context, colour ?? ink, edge, () => context.arc(...vis, size, 0, 7));
      if (tac) shape(context, colour ?? ink, edge, () => triangle(context, ...tac, size));
    }
  };
}

/** Groups with a place {x, y} for their names: where many of their points are. A mean between two clouds has none. */
export function settled(groups, of, cloud, shown) {
  const pairs = cloud.count / 2;
  const step = Math.ceil(cloud.count / MOST);
  const reach = ((NEAR * Math.max(cloud.width, cloud.height)) / cloud.ratio) ** 2;
  const members = groups.map(() => []);
  for (let point = 0; point < cloud.count; point += step)
    if (shown(point)) members[of(point % pairs)].push([cloud.x[point] / cloud.ratio, cloud.y[point] / cloud.ratio]);
  return groups.map((group, i) => {
    const around = (x, y) => members[i].filter((one) => (one[0] - x) ** 2 + (one[1] - y) ** 2 < reach);
    let near = group.both ? around(...group.both) : [];
    const least = CROWD * near.length; // a name leaves its mean for a far larger crowd only
    const every = Math.ceil(members[i].length / TRIES);
    for (let one = 0; one < members[i].length; one += every) {
      const there = around(...members[i][one]);
      if (there.length > Math.max(least, near.length)) near = there;
    }
    const mean = (axis) => near.reduce((sum, one) => sum + one[axis], 0) / near.length;
    return { ...group, x: mean(0), y: mean(1) };
  });
}

/** A painter: the name of each domain, or of each class, at its points; the source is marked. */
export function names(frames, shown) {
  return (context, cloud) => {
    const chosen = colouring(frames(), state.colour);
    const kind = ["domain", "class"].find((one) => COLOURINGS[one] === chosen);
    if (!kind) return legend(context, frames(), cloud.top);
    const groups = settled(
      groupsOf(frames(), cloud, shown, kind),
      COLOURINGS[kind].of(frames(), 0),
      cloud,
      shown,
    ).filter(({ both, name }) => both && name);
    const [width, height] = [cloud.width / cloud.ratio, cloud.height / cloud.ratio];
    const letters = isLecture() ? 20 : width < 420 ? 12 : 14;
    const high = Math.round(HIGH * (letters / 14));
    context.font = `650 ${letters}px system-ui, sans-serif`;
    const labels = groups.map(({ name, colour, x, y }) => {
      const text = name.replace(/-sim$/, "") + (name === frames().source ? " · source" : "");
      return { text, colour, x, y, wide: context.measureText(text).width + 22 };
    });
    const below = cloud.box.closest(".stage") ? 44 : 0; // Explore's buttons stand there
    context.textAlign = "left";
    context.textBaseline = "middle";
    for (const { text, colour, x, y, wide } of apart(labels, [width, height - below], high)) {
      context.beginPath();
      context.roundRect(x - wide / 2, y - high / 2, wide, high, 6);
      context.fillStyle = isDark() ? "rgb(15 23 42 / .82)" : "rgb(255 255 255 / .86)";
      context.fill();
      context.fillStyle = colour;
      context.fillRect(x - wide / 2 + 5, y - 5, 6, 10);
      context.fillStyle = isDark() ? "#f1f5f9" : "#0f172a";
      context.fillText(text, x - wide / 2 + 15, y + 0.5);
    }
    context.textBaseline = "alphabetic";
  };
}

/** The colours' names in a row, where no group has a place of its own. */
function legend(context, frames, top = 0) {
  let x = 14;
  context.font = `650 ${isLecture() ? 20 : 14}px system-ui, sans-serif`;
  context.textAlign = "left";
  for (const [name, colour] of colouring(frames, state.colour).groups(frames)) {
    context.fillStyle = colour;
    context.fillRect(x, top + 13, 10, 10);
    context.fillStyle = isDark() ? "#f1f5f9" : "#0f172a";
    context.fillText(name, x + 15, top + 23);
    x += 34 + context.measureText(name).width;
  }
}

/** Move labels {x, y, wide} up or down until none covers another and all are within the view. Those higher
 * up come first; one without room is left out. @param {any[]} labels @param {number[]} view */
export function apart(labels, [width, height], high = HIGH) {
  const taken = [];
  return [...labels]
    .sort((a, b) => a.y - b.y)
    .flatMap((label) => {
      const x = Math.max(label.wide / 2 + 2, Math.min(width - label.wide / 2 - 2, label.x));
      const free = (y) =>
        y >= high / 2 &&
        y <= height - high / 2 &&
        taken.every((o) => Math.abs(o.x - x) >= (o.wide + label.wide) / 2 || Math.abs(o.y - y) >= high);
      const steps = Array.from({ length: 80 }, (_, i) => (i % 2 ? 1 : -1) * Math.ceil(i / 2) * STEP);
      const by = steps.find((some) => free(label.y + some));
      if (by === undefined) return [];
      taken.push({ ...label, x, y: label.y + by });
      return [taken.at(-1)];
    });
}

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
