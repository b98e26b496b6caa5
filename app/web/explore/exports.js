/** Files made in the browser: CSV of points, PNG and SVG of the map. */

import { drawingOn } from "../shared/canvas.js";
import { verdict } from "../shared/card.js";
import { csv as written } from "../shared/csv.js";
import { escaped } from "../shared/text.js";

/** One line for each point: VIS and TAC of a pair are two lines. */
export function csv(frames, points, frame, stop, about) {
  const head = "pair,modality,domain,class,predicted,right,confidence,p,stage,map,x,y".split(",");
  const [[x0, y0], [x1, y1]] = frame.bounds;
  const lines = points.map((point) => {
    const pair = point % frames.pairs;
    const v = verdict(frames, pair, stop);
    const x = x0 + (frame.points[2 * point] / 65535) * (x1 - x0);
    const y = y0 + (frame.points[2 * point + 1] / 65535) * (y1 - y0);
    return [
      pair,
      point < frames.pairs ? "VIS" : "TAC",
      v.domain,
      v.truth,
      v.said,
      frames.headless ? "" : v.right,
      Number.isFinite(v.confidence) ? v.confidence.toFixed(3) : "",
      frames.orders[stop],
      about.stage,
      about.kind,
      x.toFixed(5),
      y.toFixed(5),
    ];
  });
  return written([head, ...lines]);
}

const LINE = 17; // CSS pixels between the lines under an exported map
const rule = drawingOn(new OffscreenCanvas(1, 1));

/** Positions of the legend's keys, in as many lines as the width requires. */
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

/** The map as shown, with a caption. */
export function png(cloud, caption, legend) {
  const { placed, height } = keys(legend, cloud.width / cloud.ratio);
  const canvas = document.createElement("canvas");
  canvas.width = cloud.width;
  canvas.height = cloud.height + Math.round(height * cloud.ratio);
  const x = drawingOn(canvas);
  const style = getComputedStyle(cloud.box);
  const text = style.getPropertyValue("--ov-ink").trim();
  x.fillStyle = style.getPropertyValue("--ov-card").trim();
  x.fillRect(0, 0, canvas.width, canvas.height);
  x.drawImage(cloud.ground, 0, 0);
  x.drawImage(cloud.marks, 0, 0);
  x.scale(cloud.ratio, cloud.ratio);
  x.translate(0, cloud.height / cloud.ratio);
  x.font = `12px ${style.getPropertyValue("--ov-font")}`;
  x.fillStyle = text;
  x.fillText(caption, 8, LINE);
  for (const key of placed) {
    x.fillStyle = key.colour;
    x.fillRect(key.x, key.y, 10, 10);
    x.fillStyle = text;
    x.fillText(key.name, key.x + 14, key.y + 10);
  }
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

/** The map as vector shapes; `names` of its axes, if they mean anything. */
export function svg(cloud, caption, legend, names) {
  const width = Math.round(cloud.width / cloud.ratio);
  const height = Math.round(cloud.height / cloud.ratio);
  const shapes = cloud.layers.map(({ style, at, count }) => {
    const r = style.radius;
    const drawn = [...at.subarray(0, count)].map((i) => {
      const [x, y] = cloud.place(i).map((v) => +v.toFixed(1));
      return style.shape === "circle"
        ? `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`
        : `M${x} ${y - 1.25 * r}l${1.25 * r} ${2.25 * r}h${-2.5 * r}z`;
    });
    return `<path fill="${style.colour}" fill-opacity="${style.alpha}" d="${drawn.join("")}"/>`;
  });
  const { placed, height: band } = keys(legend, width);
  const legends = placed.map(
    ({ name, colour, x, y }) =>
      `<rect x="${x}" y="${height + y}" width="10" height="10" fill="${colour}"/><text x="${x + 14}" y="${height + y + 10}">${escaped(name)}</text>`,
  );
  const text = `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height + band}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="#fff"/><svg width="${width}" height="${height}">${shapes.join("\n")}</svg>
${names ? `<text x="6" y="15" font-weight="600">↑ ${escaped(names.y)}</text><text x="${width - 8}" y="${height - 6}" font-weight="600" text-anchor="end">${escaped(names.x)} →</text>` : ""}
<text x="8" y="${height + LINE}">${escaped(caption)}</text>${legends.join("")}</svg>`;
  return new Blob([text], { type: "image/svg+xml" });
}
