/** Where points are dense: their mean colour, blurred, beneath the marks. */

import { rgb } from "./palette.js";
import { word } from "./points.js";

const CELLS = 130; // along the longer side of the map
const BLUR = 3; // cells to either side, twice
const FEW = 0.5; // opacity of a mark below which it is dimmed and has no part in the density
const DEEP = 0.34; // opacity where points are densest

/** Sum over a window of 2 BLUR + 1 cells along one direction: `step` apart, in lines `next` apart.
 * @param {Float32Array} from @param {Float32Array} to @param {number} count @param {number} step @param {number} lines
 * @param {number} next */
function along(from, to, count, step, lines, next) {
  for (let line = 0; line < lines; line++) {
    const start = line * next;
    let sum = 0;
    for (let i = 0; i < Math.min(BLUR, count); i++) sum += from[start + i * step];
    for (let i = 0; i < count; i++) {
      if (i + BLUR < count) sum += from[start + (i + BLUR) * step];
      if (i > BLUR) sum -= from[start + (i - BLUR - 1) * step];
      to[start + i * step] = sum;
    }
  }
}

/** Tint the pixels of a cloud's map, whose ground has one colour.
 * @param {import("./cloud.js").Cloud} cloud @param {string} ground */
export function density({ pixels, layers, x, y, ratio }, ground) {
  const { words, image } = pixels;
  const { width, height } = image;
  const side = Math.max(6, Math.round(Math.max(width, height) / CELLS)); // device pixels of a cell
  const [columns, rows] = [Math.ceil(width / side), Math.ceil(height / side)];
  const cell = side / ratio; // as x and y
  const [red, green, blue, weight, spare] = Array.from({ length: 5 }, () => new Float32Array(columns * rows));
  for (const { style, at, count } of layers) {
    if (style.alpha < FEW) continue;
    const [r, g, b] = rgb(style.colour);
    for (let n = 0; n < count; n++) {
      const [cx, cy] = [(x[at[n]] / cell) | 0, (y[at[n]] / cell) | 0];
      if (cx < 0 || cy < 0 || cx >= columns || cy >= rows) continue;
      const i = cy * columns + cx;
      red[i] += r;
      green[i] += g;
      blue[i] += b;
      weight[i] += 1;
    }
  }
  for (const sums of [red, green, blue, weight]) {
    for (let twice = 0; twice < 2; twice++) {
      along(sums, spare, columns, 1, rows, columns);
      along(spare, sums, rows, columns, columns, 1);
    }
  }
  const most = weight.reduce((a, b) => Math.max(a, b), 0);
  const [r, g, b] = rgb(ground);
  for (let row = 0; row < rows; row++) {
    const start = row * side * width;
    for (let column = 0; column < columns; column++) {
      const i = row * columns + column;
      const w = weight[i];
      if (w < 0.5) continue;
      const share = DEEP * (1 - Math.exp((-3 * w) / most));
      /** @param {number} from @param {number} sum */
      const mixed = (from, sum) => from + share * (sum / w - from);
      const colour = word(mixed(r, red[i]), mixed(g, green[i]), mixed(b, blue[i]));
      words.fill(colour, start + column * side, start + Math.min(width, (column + 1) * side));
    }
    for (let line = 1; line < side && row * side + line < height; line++)
      words.copyWithin(start + line * width, start, start + width);
  }
}
