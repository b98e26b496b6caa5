/** Attention weights as pictures: token to token at this p, and what each token gets over p. */

import { isDark, rgb } from "./palette.js";
import { escaped } from "./text.js";

const NAMES = { vis: "● VIS", tac: "▲ TAC" };
const ROWS = 101;
const [MORE, LESS] = ["#d55e00", "#2f86c4"].map(rgb);

export class Attention {
  constructor(box) {
    this.box = box;
    this.all = [];
    this.stop = 0;
  }

  /** found: what the server says; null for none, {problem} for a sentence. */
  show(found) {
    this.all = [];
    if (!found) return void (this.box.innerHTML = "");
    if (found.problem) return void (this.box.innerHTML = `<p class="hint">${escaped(found.problem)}</p>`);
    const names = Object.keys(found.off);
    this.box.innerHTML = `${names.map((name) => `<figure data-name="${name}"><figcaption>${NAMES[name]}</figcaption>
      <canvas class="square" role="img" aria-label="Attention of each token of ${NAMES[name]} to each, at this p"></canvas>
      <div class="strip"><canvas role="img" aria-label="Attention that each token of ${NAMES[name]} gets, over p"></canvas><i></i></div>
      <p class="hint figure"></p></figure>`).join("")}
      <p class="hint">Each modality is ${found.count[names[0]]} tokens: real parts, then imaginary parts, each times a learned θ and cut by the ReLU. Above: row asks, column is looked at. Below: what each token gets on average, p from 0 to 1. <i class="swatch" style="background:#d55e00"></i> Orange gets more than an even share, <i class="swatch" style="background:#2f86c4"></i> blue less; full colour is ${(100 * found.scale).toPrecision(2)} points off, the most at any p.</p>`;
    this.all = names.map((name) => ({
      name, count: found.count[name], tokens: found.tokens[name],
      bytes: Int8Array.from(atob(found.off[name]), (c) => c.charCodeAt(0)),
      figure: this.box.querySelector(`[data-name="${name}"]`),
    }));
    this.scale = found.scale;
    this.paint();
  }

  /** Paint what does not move with p. */
  paint() {
    for (const one of this.all) {
      const { count, bytes } = one;
      const means = new Float32Array(ROWS * count);
      for (let stop = 0; stop < ROWS; stop++) {
        for (let row = 0; row < count; row++) {
          for (let column = 0; column < count; column++) {
            means[stop * count + column] += bytes[(stop * count + row) * count + column] / count;
          }
        }
      }
      one.means = means;
      picture(one.figure.querySelector(".strip canvas"), ROWS, count, (x, y) => means[x * count + y] / 127);
    }
    this.mark(this.stop);
  }

  mark(stop) {
    this.stop = stop;
    for (const one of this.all) {
      const { count, bytes, figure, means, tokens } = one;
      picture(figure.querySelector(".square"), count, count, (x, y) => bytes[(stop * count + y) * count + x] / 127);
      figure.querySelector(".strip i").style.left = `${(100 * (stop + 0.5)) / ROWS}%`;
      const own = [...means.subarray(stop * count, (stop + 1) * count)];
      const best = own.indexOf(Math.max(...own));
      figure.querySelector(".figure").textContent = `most to token ${best + 1} (${tokens[best]}): ${(100 / count + (100 * this.scale * own[best]) / 127).toFixed(1)} %; evenly would be ${(100 / count).toFixed(1)} %`;
    }
  }
}

/** share(x, y) from −1 (blue) to 1 (orange), 0 is paper. */
function picture(canvas, width, height, share) {
  const paper = rgb(isDark() ? "#0f172a" : "#ffffff");
  canvas.width = width;
  canvas.height = height;
  const image = new ImageData(width, height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const v = Math.max(-1, Math.min(1, share(x, y)));
      const ink = v > 0 ? MORE : LESS;
      image.data.set([...paper.map((from, c) => Math.round(from + (ink[c] - from) * Math.abs(v))), 255], 4 * (y * width + x));
    }
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
}
