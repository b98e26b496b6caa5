/** Marks above the points: axes with figures, the pair's line, neighbours, the lasso. */

import { segment, stroked } from "./canvas.js";
import { isLecture, onTheme } from "./palette.js";

const GRID = 90; // CSS pixels between two figures on an axis, about

/** @typedef {CanvasRenderingContext2D} Context @typedef {import("./cloud.js").Cloud} Cloud */
/** @type {Map<string, string>} */
const inks = new Map();
onTheme(() => inks.clear());

/** Return a variable of the style sheet, read once for each theme. @param {Element} canvas @param {string} name */
export function ink(canvas, name) {
  let found = inks.get(name);
  if (!found) inks.set(name, (found = getComputedStyle(canvas).getPropertyValue(name).trim()));
  return found;
}

/** @param {number} span */
function niceStep(span) {
  const power = 10 ** Math.floor(Math.log10(span));
  return [1, 2, 5].map((m) => m * power).find((step) => step >= span) ?? 10 * power;
}

/** @param {number} value @param {number} step */
const figure = (value, step) => {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return (Math.abs(value) < step / 2 ? 0 : value).toFixed(Math.min(6, digits));
};

/** Return the axis labels of a kind of map; null for UMAP, whose axes and scale have no meaning.
 * @param {string} kind */
export const axisNames = (kind) =>
  kind === "umap" ? null : { x: "principal component 1", y: "principal component 2" };

/** Return axes of the map: thin lines at round figures, and axis labels, if it has names for them.
 * @param {() => ReturnType<typeof axisNames>} names @returns {Painter} */
export function axes(names) {
  return (context, cloud) => {
    const full = names();
    if (!full) return;
    const { scale, middle, ox, oy } = cloud.transform();
    const { width, height } = cloud;
    const step = niceStep(GRID / scale);
    const left = middle.x - ox / scale;
    const top = middle.y + oy / scale;
    const colour = ink(cloud.box, "--ov-muted");
    const [across, up] = [full.x, full.y].map((name) =>
      width < 280 ? name.replace("principal component", "PC") : name,
    );
    const [small, bold] = ["11px", "600 12px"].map((size) => `${size} ${ink(cloud.box, "--ov-font")}`);
    context.fillStyle = colour;
    context.textBaseline = "alphabetic";
    context.font = bold;
    const taken = width - 34 - context.measureText(`${across} →`).width; // start of the axis label
    context.font = small;
    /** @param {Point} from @param {Point} to */
    const line = (from, to) => {
      context.globalAlpha = 0.13;
      stroked(context, () => segment(context, from, to), [1, colour]);
      context.globalAlpha = 1;
    };
    context.textAlign = "center";
    for (let v = Math.ceil(left / step) * step; (v - left) * scale < width; v += step) {
      const x = (v - left) * scale;
      if (x < 34) continue;
      line([x, 0], [x, height]);
      if (x < taken) context.fillText(figure(v, step), x, height - 6);
    }
    context.textAlign = "left";
    for (let v = Math.floor(top / step) * step; (top - v) * scale < height - 24; v -= step) {
      const y = (top - v) * scale;
      if (y < 34) continue;
      line([0, y], [width, y]);
      context.fillText(figure(v, step), 6, y - 3);
    }
    context.font = bold;
    context.textAlign = "right";
    context.fillText(`${across} →`, width - 8, height - 6);
    const aside = cloud.box.closest(".stage"); // the tools stand at its upper left
    context.textAlign = aside ? "right" : "left";
    context.fillText(`↑ ${up}`, aside ? width - 8 : 6, 15);
  };
}

/** @param {Context} context @param {Point} place @param {number} radius @param {string} colour */
const ring = (context, place, radius, colour, width = 2.5) =>
  stroked(context, () => context.arc(...place, radius, 0, 7), [width + 2.5, "#fff"], [width, colour]);

/** Draw a pair: the places of its photo and touch, named, and the line between them; of one image, its place.
 * @param {Context} context @param {Cloud} cloud @param {(Point | undefined)[]} places @param {string} colour
 * @param {string[]} names of photo and touch */
export function pairLine(context, cloud, places, colour, names) {
  const [vis, tac] = places;
  if (vis && tac) stroked(context, () => segment(context, vis, tac), [5, "#fff"], [2.2, colour]);
  context.font = `700 11px ${ink(cloud.box, "--ov-font")}`;
  context.textAlign = "center";
  context.fillStyle = colour;
  const high = Math.min(...[vis, tac].flatMap((place) => place?.[1] ?? []));
  for (const [k, place] of places.entries()) {
    if (!place) continue;
    const [x, y] = place;
    const at = y + (y === high ? -14 : 22);
    ring(context, place, 8, colour);
    context.lineWidth = 4;
    context.strokeStyle = "#fff";
    context.strokeText(names[k], x, at);
    context.fillText(names[k], x, at);
  }
}

/** @param {Context} context @param {Cloud} cloud @param {number[]} points */
export function neighbourRings(context, cloud, points) {
  for (const point of points) ring(context, cloud.place(point), 6, "#16a34a", 1.8);
}

/** Draw what the shapes stand for, at the upper right of a map without axes.
 * @param {Context} context @param {Cloud} cloud @param {string} words */
export function shapes(context, cloud, words) {
  context.font = `600 ${isLecture() ? 20 : 13}px ${ink(cloud.box, "--ov-font")}`;
  context.fillStyle = ink(cloud.box, "--ov-muted");
  context.textAlign = "right";
  context.fillText(words, cloud.width - 12, 23);
}

/** Draw the lasso as it is dragged. @param {Context} context @param {Point[] | null} polygon */
export function lassoLine(context, polygon) {
  if (!polygon || polygon.length < 2) return;
  context.fillStyle = "rgba(37, 99, 235, .12)";
  context.setLineDash([5, 4]);
  const trace = () => {
    for (const corner of polygon) context.lineTo(...corner);
    context.closePath();
  };
  stroked(context, trace, [2, "#2563eb"]);
  context.fill();
  context.setLineDash([]);
}
