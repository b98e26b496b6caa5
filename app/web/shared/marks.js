/** Marks above the points: axes with figures, the pair's line, neighbours, the lasso. */

import { isLecture, onTheme } from "./palette.js";

const GRID = 90; // CSS pixels between two figures on an axis, about

const inks = new Map();
onTheme(() => inks.clear());

/** A variable of the style sheet, read once for each theme. */
function ink(canvas, name) {
  if (!inks.has(name)) inks.set(name, getComputedStyle(canvas).getPropertyValue(name).trim());
  return inks.get(name);
}

function niceStep(span) {
  const power = 10 ** Math.floor(Math.log10(span));
  return [1, 2, 5].map((m) => m * power).find((step) => step >= span) ?? 10 * power;
}

const figure = (value, step) => {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return (Math.abs(value) < step / 2 ? 0 : value).toFixed(Math.min(6, digits));
};

/** The axis labels of a kind of map; null for UMAP, whose axes and scale have no meaning. */
export const axisNames = (kind) =>
  kind === "umap" ? null : { x: "principal component 1", y: "principal component 2" };

/** Axes of the map: thin lines at round figures, and axis labels, if it has names for them. */
export function axes(names) {
  return (context, cloud) => {
    const full = names();
    if (!full) return;
    const { scale, middle, ox, oy } = cloud.transform();
    const width = cloud.width / cloud.ratio;
    const height = cloud.height / cloud.ratio;
    const per = scale / cloud.ratio; // CSS pixels for one unit
    const step = niceStep(GRID / per);
    const left = middle.x + (0 - ox / cloud.ratio) / per;
    const top = middle.y + oy / cloud.ratio / per;
    context.fillStyle = context.strokeStyle = ink(cloud.box, "--ov-muted");
    context.font = `11px ${ink(cloud.box, "--ov-font")}`;
    context.textBaseline = "alphabetic";
    context.textAlign = "center";
    context.lineWidth = 1;
    const [across, up] = [full.x, full.y].map((name) =>
      width < 280 ? name.replace("principal component", "PC") : name,
    );
    const small = context.font;
    context.font = `600 12px ${ink(cloud.box, "--ov-font")}`;
    const taken = width - 34 - context.measureText(`${across} →`).width; // start of the axis label
    context.font = small;
    for (let v = Math.ceil(left / step) * step; (v - left) * per < width; v += step) {
      const x = (v - left) * per;
      if (x < 34) continue;
      context.globalAlpha = 0.13;
      line(context, x, 0, x, height);
      context.globalAlpha = 1;
      if (x < taken) context.fillText(figure(v, step), x, height - 6);
    }
    context.textAlign = "left";
    for (let v = Math.floor(top / step) * step; (top - v) * per < height - 24; v -= step) {
      const y = (top - v) * per;
      if (y < 34) continue;
      context.globalAlpha = 0.13;
      line(context, 0, y, width, y);
      context.globalAlpha = 1;
      context.fillText(figure(v, step), 6, y - 3);
    }
    context.font = `600 12px ${ink(cloud.box, "--ov-font")}`;
    context.textAlign = "right";
    context.fillText(`${across} →`, width - 8, height - 6);
    context.textAlign = "left";
    const aside = cloud.box.closest(".stage"); // the tools stand at its upper left
    context.textAlign = aside ? "right" : "left";
    context.fillText(`↑ ${up}`, aside ? width - 8 : 6, 15);
  };
}

function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

function ring(context, [x, y], radius, colour, width = 2.5) {
  context.beginPath();
  context.arc(x, y, radius, 0, 7);
  context.lineWidth = width + 2.5;
  context.strokeStyle = "#fff";
  context.stroke();
  context.lineWidth = width;
  context.strokeStyle = colour;
  context.stroke();
}

/** The two points of a pair and the line between them. */
export function pairLine(context, cloud, pair, colour) {
  const half = cloud.count / 2;
  const [a, b] = [cloud.place(pair), cloud.place(pair + half)];
  for (const [width, stroke] of [
    [5, "#fff"],
    [2.2, colour],
  ]) {
    context.lineWidth = width;
    context.strokeStyle = stroke;
    line(context, ...a, ...b);
  }
  ring(context, a, 8, colour);
  ring(context, b, 8, colour);
  context.font = `700 11px ${ink(cloud.box, "--ov-font")}`;
  context.textAlign = "center";
  for (const [place, text] of [
    [a, "VIS"],
    [b, "TAC"],
  ]) {
    const up = (place === a) === a[1] <= b[1] ? -14 : 22;
    context.lineWidth = 4;
    context.strokeStyle = "#fff";
    context.strokeText(text, place[0], place[1] + up);
    context.fillStyle = colour;
    context.fillText(text, place[0], place[1] + up);
  }
}

export const neighbourRings = (context, cloud, points) =>
  points.forEach((point) => ring(context, cloud.place(point), 6, "#16a34a", 1.8));

/** What the shapes stand for, at the upper right of a map without axes. */
export function shapes(context, cloud, words) {
  context.font = `600 ${isLecture() ? 20 : 13}px ${ink(cloud.box, "--ov-font")}`;
  context.fillStyle = ink(cloud.box, "--ov-muted");
  context.textAlign = "right";
  context.fillText(words, cloud.width / cloud.ratio - 12, 23);
}

export function lassoLine(context, polygon) {
  if (!polygon || polygon.length < 2) return;
  context.beginPath();
  polygon.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.closePath();
  context.fillStyle = "rgba(37, 99, 235, .12)";
  context.fill();
  context.lineWidth = 2;
  context.setLineDash([5, 4]);
  context.strokeStyle = "#2563eb";
  context.stroke();
  context.setLineDash([]);
}
