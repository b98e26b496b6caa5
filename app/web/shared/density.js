/** Where points are dense: their mean colour, blurred, beneath the marks. */

import { rgb } from "./palette.js";

const CELLS = 130; // along the longer side of the map
const BLUR = 3; // cells to either side, twice
const FEW = 0.5; // opacity of a mark below which it is dimmed and has no part in the density
const DEEP = 0.34; // opacity where points are densest
const grids = new Map();

/** A row of numbers for each of red, green, blue and weight. */
function grid(columns, rows) {
  const key = `${columns} ${rows}`;
  if (!grids.has(key)) {
    if (grids.size > 6) grids.clear();
    const made = () => Array.from({ length: 4 }, () => new Float32Array(columns * rows));
    grids.set(key, [made(), new Float32Array(columns * rows)]);
  }
  const [sums, spare] = grids.get(key);
  for (const one of sums) one.fill(0);
  return { sums, spare };
}

/** Sum over a window of 2 BLUR + 1 cells along one direction: `step` apart, in lines `next` apart. */
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

/** Tint the pixels `words` of a cloud's map, whose ground has one colour. */
export function density(words, { layers, x, y, width, height }, ground) {
  const cell = Math.max(6, Math.round(Math.max(width, height) / CELLS));
  const [columns, rows] = [Math.ceil(width / cell), Math.ceil(height / cell)];
  const { sums, spare } = grid(columns, rows);
  let total = 0;
  for (const { style, at, count } of layers) {
    if (style.alpha < FEW) continue;
    const colour = rgb(style.colour);
    total += count;
    for (let n = 0; n < count; n++) {
      const [cx, cy] = [(x[at[n]] / cell) | 0, (y[at[n]] / cell) | 0];
      if (cx < 0 || cy < 0 || cx >= columns || cy >= rows) continue;
      const i = cy * columns + cx;
      for (let c = 0; c < 3; c++) sums[c][i] += colour[c];
      sums[3][i] += 1;
    }
  }
  if (!total) return;
  for (const one of sums) {
    for (let twice = 0; twice < 2; twice++) {
      along(one, spare, columns, 1, rows, columns);
      along(spare, one, rows, columns, columns, 1);
    }
  }
  paint(words, { sums, columns, rows, width, height, cell }, rgb(ground));
}

function paint(words, { sums, columns, rows, width, height, cell }, ground) {
  const [red, green, blue, weight] = sums;
  let most = 0;
  for (const w of weight) if (w > most) most = w;
  for (let row = 0; row < rows; row++) {
    const start = row * cell * width;
    for (let column = 0; column < columns; column++) {
      const i = row * columns + column;
      const w = weight[i];
      if (w < 0.5) continue;
      const share = DEEP * (1 - Math.exp((-3 * w) / most));
      const r = ground[0] + share * (red[i] / w - ground[0]);
      const g = ground[1] + share * (green[i] / w - ground[1]);
      const b = ground[2] + share * (blue[i] / w - ground[2]);
      const word = (0xff000000 | (b << 16) | (g << 8) | r) >>> 0;
      words.fill(word, start + column * cell, start + Math.min(width, (column + 1) * cell));
    }
    for (let line = 1; line < cell && row * cell + line < height; line++)
      words.copyWithin(start + line * width, start, start + width);
  }
}
