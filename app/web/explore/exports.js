/** Files made in the browser: CSV of points, PNG and SVG of the map. */

import { drawingOn } from "../shared/canvas.js";
import { verdict } from "../shared/card.js";
import { csv as written } from "../shared/csv.js";
import { OUTLINES } from "../shared/points.js";
import { html } from "./root.js";

/** @typedef {import("../shared/cloud.js").Cloud} Cloud */
/** @typedef {[name: string, colour: string][]} Legend */

/** Return one line for each point: VIS and TAC of a pair are two lines.
 * @param {Frames} frames @param {number[]} points @param {Positions} frame @param {number} stop
 * @param {{stage: string, map: string}} about */
export function csv(frames, points, frame, stop, { stage, map }) {
  const head = "pair,modality,domain,class,predicted,right,confidence,p,stage,map,x,y".split(",");
  const [low, high] = frame.bounds;
  const lines = points.map((point) => {
    const pair = point % frames.pairs;
    const { domain, truth, said, right, confidence } = verdict(frames, pair, stop);
    const place = [0, 1].map((axis) =>
      (low[axis] + (frame.points[2 * point + axis] / 65535) * (high[axis] - low[axis])).toFixed(5),
    );
    const sure = Number.isFinite(confidence) ? confidence.toFixed(3) : "";
    const read = [said, frames.headless ? "" : String(right), sure, frames.orders[stop]];
    return [pair, point < frames.pairs ? "VIS" : "TAC", domain, truth, ...read, stage, map, ...place];
  });
  return written([head, ...lines]);
}

const LINE = 17; // CSS pixels between the lines under an exported map
const rule = drawingOn(new OffscreenCanvas(1, 1));

/** Return positions of the legend's keys, in as many lines as the width requires.
 * @param {Legend} legend
 * @param {number} width */
function keys(legend, width) {
  rule.font = "12px sans-serif";
  let left = 8;
  let row = 0;
  const placed = legend.map(([name, colour]) => {
    const wide = 30 + rule.measureText(name).width;
    if (left + wide > width && left > 8) {
      left = 8;
      row += 1;
    }
    const key = { name, colour, x: left, y: (row + 1) * LINE + 8 };
    left += wide;
    return key;
  });
  return { placed, height: (row + 2) * LINE + 8 };
}

/** Return the map as shown, with a caption.
 * @param {Cloud} cloud @param {string} caption @param {Legend} legend
 * @returns {Promise<Blob>} */
export function png(cloud, caption, legend) {
  const { placed, height } = keys(legend, cloud.width);
  const canvas = document.createElement("canvas");
  canvas.width = cloud.ground.width;
  canvas.height = cloud.ground.height + Math.round(height * cloud.ratio);
  const x = drawingOn(canvas);
  const style = getComputedStyle(cloud.box);
  const ink = style.getPropertyValue("--ov-ink").trim();
  x.fillStyle = style.getPropertyValue("--ov-card").trim();
  x.fillRect(0, 0, canvas.width, canvas.height);
  x.drawImage(cloud.ground, 0, 0);
  x.drawImage(cloud.marks, 0, 0);
  x.scale(cloud.ratio, cloud.ratio);
  x.translate(0, cloud.height);
  x.font = `12px ${style.getPropertyValue("--ov-font")}`;
  x.fillStyle = ink;
  x.fillText(caption, 8, LINE);
  for (const key of placed) {
    x.fillStyle = key.colour;
    x.fillRect(key.x, key.y, 10, 10);
    x.fillStyle = ink;
    x.fillText(key.name, key.x + 14, key.y + 10);
  }
  return new Promise((resolve) => canvas.toBlob((blob) => resolve(/** @type {Blob} */ (blob)), "image/png"));
}

/** Return the map as vector shapes; `names` of its axes, if they mean anything.
 * @param {Cloud} cloud @param {string} caption @param {Legend} legend
 * @param {ReturnType<typeof import("../shared/marks.js").axisNames>} names */
export function svg(cloud, caption, legend, names) {
  const [width, height] = [cloud.width, cloud.height].map(Math.round);
  const shapes = cloud.layers.map(({ style: { shape, colour, radius, alpha }, at, count }, i) => {
    const drawn = [...at.subarray(0, count)].map((point) => {
      const [x, y] = cloud.place(point).map((v) => +v.toFixed(1));
      return OUTLINES[shape](x, y, radius);
    });
    return html`${i > 0 && "\n"}<path fill="${colour}" fill-opacity="${alpha}" d="${drawn.join("")}"/>`;
  });
  const { placed, height: band } = keys(legend, width);
  const legends = placed.map(
    ({ name, colour, x, y }) =>
      html`<rect x="${x}" y="${height + y}" width="10" height="10" fill="${colour}"/><text x="${x + 14}"
        y="${height + y + 10}">${name}</text>`,
  );
  const axes =
    names &&
    html`<text x="6" y="15" font-weight="600">↑ ${names.y}</text>
      <text x="${width - 8}" y="${height - 6}" font-weight="600" text-anchor="end">${names.x} →</text>`;
  const text = html`<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height + band}"
    font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="#fff"/><svg width="${width}" height="${height}">${shapes}</svg>
${axes}
<text x="8" y="${height + LINE}">${caption}</text>${legends}</svg>`;
  return new Blob([String(text)], { type: "image/svg+xml" });
}
