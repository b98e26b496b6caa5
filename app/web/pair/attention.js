/** Attention among the tokens of one modality; a sentence replaces a uniform one. */

import { isDark, rgb } from "../shared/palette.js";
import { bytesOf, escaped } from "../shared/text.js";

const NAMES = { vis: ["vis", "Photo"], tac: ["tac", "Touch"] };
const ROWS = 101;
const WORTH = 0.01; // smaller differences from uniform are not shown
const [MORE, LESS] = ["#d55e00", "#2f86c4"].map(rgb);

/** A sentence about the weights. scale: the largest distance of a weight from 1/count. */
export function about(count, scale) {
  const points = (100 * scale).toPrecision(2);
  const even = (100 / count).toFixed(1);
  if (scale < WORTH) {
    return `Nothing to see: each of the ${count} tokens gets the uniform ${even} %, within ${points} points, at every p.`;
  }
  return `Rows attend to columns, over ${count} tokens (real parts, then imaginary). Uniform: ${even} %. Orange is more, blue is less; full colour is ${points} points.`;
}

export class Attention {
  constructor(box) {
    this.box = box;
    this.all = [];
    this.stop = 0;
  }

  /** found: the server's reply; null for none, {problem} for a sentence. */
  show(found) {
    this.all = [];
    this.box.innerHTML = "";
    if (!found) return;
    if (found.problem) {
      this.box.innerHTML = `<p class="hint">${escaped(found.problem)}</p>`;
      return;
    }
    const names = Object.keys(found.off);
    this.box.innerHTML = `<p class="hint">${about(found.count[names[0]], found.scale)}</p>`;
    if (found.scale < WORTH) return;
    this.box.insertAdjacentHTML("beforeend", names.map(figure).join(""));
    this.all = names.map((name) => ({
      count: found.count[name],
      bytes: new Int8Array(bytesOf(found.off[name]).buffer),
      canvas: this.box.querySelector(`[data-name="${name}"] canvas`),
    }));
    this.paint();
  }

  paint() {
    this.mark(this.stop);
  }

  mark(stop) {
    this.stop = Math.min(stop, ROWS - 1);
    for (const { count, bytes, canvas } of this.all) {
      picture(canvas, count, (x, y) => bytes[(this.stop * count + y) * count + x] / 127);
    }
  }
}

const figure = (name) => {
  const [sign, title] = NAMES[name];
  return `<figure data-name="${name}"><figcaption><span class="sign ${sign}"></span>${title}</figcaption><canvas class="square" role="img" aria-label="Attention of each token of the ${title.toLowerCase()} to each, at this p"></canvas></figure>`;
};

/** share(x, y) from −1 (blue) to 1 (orange), 0 is paper. */
function picture(canvas, side, share) {
  const paper = rgb(isDark() ? "#0f172a" : "#ffffff");
  canvas.width = canvas.height = side;
  const image = new ImageData(side, side);
  for (let y = 0; y < side; y++) {
    for (let x = 0; x < side; x++) {
      const v = Math.max(-1, Math.min(1, share(x, y)));
      const ink = v > 0 ? MORE : LESS;
      const mixed = paper.map((from, c) => Math.round(from + (ink[c] - from) * Math.abs(v)));
      image.data.set([...mixed, 255], 4 * (y * side + x));
    }
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
}
