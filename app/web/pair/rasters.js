/** Pictures of numbers: the fractional spectrum of an image, the attention among its tokens, and parts that matter. */

import { paintCells } from "../shared/canvas.js";
import { isDark, ramp, rgb, TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { bytesOf, each, escaped } from "../shared/text.js";

const COLOURS = { vis: VIS_COLOUR, tac: TAC_COLOUR };
const NAMES = { vis: "● VIS", tac: "▲ TAC" };
const TITLES = { vis: "Photo", tac: "Touch" };
const ROWS = 101;
const WORTH = 0.01; // smaller differences from uniform are not shown
const [MORE, LESS] = ["#d55e00", "#2f86c4"].map(rgb);

/** |F_p| over p, the current p marked, and its profile beneath. */
export class Spectra {
  constructor(box) {
    this.box = box;
    this.all = [];
  }

  show(spectra) {
    this.box.innerHTML = each(
      Object.entries(spectra),
      ([name, { width, top }]) => `<figure><figcaption>${NAMES[name]}</figcaption>
      <div class="heat"><span class="up">p</span><canvas role="img" aria-label="Spectrum of ${NAMES[name]} over p"></canvas><i class="cursor"></i></div>
      <canvas class="profile" role="img" aria-label="Spectrum of ${NAMES[name]} at the current p"></canvas>
      <p class="scale"><span>entry 0</span><span>${width} entries · brightest = ${top.toPrecision(3)}</span><span>${width - 1}</span></p></figure>`,
    );
    const figures = this.box.querySelectorAll("figure");
    this.all = Object.entries(spectra).map(([name, s], i) => ({
      ...s,
      name,
      bytes: bytesOf(s.pixels),
      figure: figures[i],
    }));
    this.paint();
  }

  /** Row 0 is p = 0 and lies at the bottom. */
  paint() {
    const colours = ramp(isDark());
    for (const { figure, bytes, columns, rows } of this.all) {
      const strength = (x, y) => Math.sqrt(bytes[(rows - 1 - y) * columns + x] / 255);
      paintCells(figure.querySelector("canvas"), columns, rows, (x, y) => colours[Math.round(255 * strength(x, y))]);
    }
  }

  mark(stop) {
    for (const { figure, bytes, columns, rows, name } of this.all) {
      figure.querySelector(".cursor").style.top = `${(100 * (rows - 0.5 - stop)) / rows}%`;
      const canvas = figure.querySelector(".profile");
      [canvas.width, canvas.height] = [2 * columns, 90];
      const x = canvas.getContext("2d");
      x.fillStyle = COLOURS[name];
      for (let column = 0; column < columns; column++) {
        const high = (bytes[stop * columns + column] / 255) * (canvas.height - 4);
        x.fillRect(2 * column, canvas.height - high, 2, high);
      }
    }
  }
}

/** A sentence about the weights. scale: the largest distance of a weight from 1/count. */
export function about(count, scale) {
  const points = (100 * scale).toPrecision(2);
  const even = (100 / count).toFixed(1);
  if (scale < WORTH) {
    return `Nothing to see: each of the ${count} tokens gets the uniform ${even} %, within ${points} points, at every p.`;
  }
  return `Rows attend to columns, over ${count} tokens (real parts, then imaginary). Uniform: ${even} %. Orange is more, blue is less; full colour is ${points} points.`;
}

/** Attention among the tokens of one modality; a sentence replaces a uniform one. */
export class Attention {
  constructor(box) {
    this.box = box;
    this.all = [];
    this.stop = 0;
  }

  /** found: the server's reply; null for none, {problem} for a sentence. */
  show(found) {
    this.all = [];
    const names = Object.keys(found?.off ?? {});
    const sentence = found?.problem ?? (found ? about(found.count[names[0]], found.scale) : "");
    const shown = found?.scale >= WORTH ? names : [];
    this.box.innerHTML = (sentence && `<p class="hint">${escaped(sentence)}</p>`) + each(shown, figure);
    this.all = shown.map((name) => ({
      count: found.count[name],
      bytes: new Int8Array(bytesOf(found.off[name]).buffer),
      canvas: this.box.querySelector(`[data-name="${name}"] canvas`),
    }));
    this.mark(this.stop);
  }

  /** From −1 (blue) to 1 (orange); 0 is paper. */
  mark(stop = this.stop) {
    this.stop = Math.min(stop, ROWS - 1);
    const paper = rgb(isDark() ? "#0f172a" : "#ffffff");
    for (const { count, bytes, canvas } of this.all)
      paintCells(canvas, count, count, (x, y) => {
        const v = Math.max(-1, Math.min(1, bytes[(this.stop * count + y) * count + x] / 127));
        const ink = v > 0 ? MORE : LESS;
        return paper.map((from, c) => Math.round(from + (ink[c] - from) * Math.abs(v)));
      });
  }
}

const figure = (name) =>
  `<figure data-name="${name}"><figcaption><span class="sign ${name}"></span>${TITLES[name]}</figcaption><canvas class="square" role="img" aria-label="Attention of each token of the ${TITLES[name].toLowerCase()} to each, at this p"></canvas></figure>`;
