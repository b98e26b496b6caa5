/** Files made in the browser: CSV of points, PNG and SVG of the map. */

import { escaped } from "./text.js";
import { verdict } from "./card.js";

export function download(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

const cell = (value) => (/[",\n]/.test(value) ? `"${String(value).replaceAll('"', '""')}"` : value);

/** One line for each point: VIS and TAC of a pair are two lines. */
export function csv(frames, points, frame, stop, about) {
  const head = "pair,modality,domain,class,predicted,right,confidence,p,stage,map,x,y";
  const [[x0, y0], [x1, y1]] = frame.bounds;
  const lines = points.map((point) => {
    const pair = point % frames.pairs;
    const v = verdict(frames, pair, stop);
    const x = x0 + (frame.points[2 * point] / 65535) * (x1 - x0);
    const y = y0 + (frame.points[2 * point + 1] / 65535) * (y1 - y0);
    return [
      pair, point < frames.pairs ? "VIS" : "TAC", v.domain, v.truth, v.said, v.right,
      v.confidence.toFixed(3), frames.orders[stop], about.stage, about.kind, x.toFixed(5), y.toFixed(5),
    ].map(cell).join(",");
  });
  return new Blob([[head, ...lines].join("\n") + "\n"], { type: "text/csv" });
}

/** The map with a caption, as it is on the screen. */
export function png(cloud, caption, legend) {
  const band = Math.round(46 * cloud.ratio);
  const canvas = document.createElement("canvas");
  canvas.width = cloud.width;
  canvas.height = cloud.height + band;
  const x = canvas.getContext("2d");
  const style = getComputedStyle(cloud.box);
  x.fillStyle = style.getPropertyValue("--ov-card").trim() || "#fff";
  x.fillRect(0, 0, canvas.width, canvas.height);
  x.drawImage(cloud.ground, 0, 0);
  x.drawImage(cloud.marks, 0, 0);
  x.scale(cloud.ratio, cloud.ratio);
  x.font = `12px ${style.getPropertyValue("--ov-font")}`;
  const top = cloud.height / cloud.ratio;
  const text = style.getPropertyValue("--ov-ink").trim();
  x.fillStyle = text;
  x.fillText(caption, 8, top + 17);
  let left = 8;
  for (const [name, colour] of legend) {
    x.fillStyle = colour;
    x.fillRect(left, top + 26, 10, 10);
    x.fillStyle = text;
    x.fillText(name, left + 14, top + 35);
    left += 26 + x.measureText(name).width;
  }
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

/** The map as shapes that a drawing program can open. */
export function svg(cloud, caption, legend) {
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
  let left = 8;
  const keys = legend.map(([name, colour]) => {
    const key = `<rect x="${left}" y="${height + 26}" width="10" height="10" fill="${colour}"/><text x="${left + 14}" y="${height + 35}">${escaped(name)}</text>`;
    left += 26 + 7 * name.length;
    return key;
  });
  const text = `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height + 46}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="#fff"/><svg width="${width}" height="${height}">${shapes.join("\n")}</svg>
<text x="8" y="${height + 17}">${escaped(caption)}</text>${keys.join("")}</svg>`;
  return new Blob([text], { type: "image/svg+xml" });
}
