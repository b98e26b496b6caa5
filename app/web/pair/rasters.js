/** Pictures of numbers: the fractional spectrum of an image, and the attention among its tokens. */

import { drawingOn, paintCells } from "../shared/canvas.js";
import { isDark, ramp, rgb, TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { bytesOf } from "../shared/text.js";
import { View } from "../shared/view.js";
import { hint, html, imagesOf, percent, put, signed, TERMS } from "./parts.js";

const COLOURS = { vis: VIS_COLOUR, tac: TAC_COLOUR };
const WORTH = 0.01; // smaller differences from uniform are not shown
const [MORE, LESS] = ["#d55e00", "#2f86c4"].map(rgb);

/** |F_p| over p, the current p marked, and its profile beneath. */
export class Spectra extends View {
  /** @type {(Spectrum & {bytes: Uint8Array, figure: Element, colour: string})[]} */
  all = [];

  /** @param {Predicted["spectra"]} spectra */
  show(spectra) {
    const there = imagesOf(spectra);
    put(
      this.box,
      html`${there.map((name) => {
        const { width, top } = spectra[name];
        const { title, one } = TERMS[name];
        return html`<figure><figcaption>${signed(name, title)}</figcaption>
      <div class="heat"><span class="up">p</span>
        <canvas role="img" aria-label="Spectrum of the ${one} over p"></canvas><i class="cursor"></i></div>
      <canvas class="profile" role="img" aria-label="Spectrum of the ${one} at the current p"></canvas>
      <p class="ends hint"><span>entry 0</span><span>${width} entries · brightest = ${top.toPrecision(3)}</span>
        <span>${width - 1}</span></p></figure>`;
      })}`,
    );
    this.all = there.map((name, i) => ({
      ...spectra[name],
      bytes: bytesOf(spectra[name].pixels),
      figure: this.box.querySelectorAll("figure")[i],
      colour: COLOURS[name],
    }));
    this.paint();
  }

  /** Row 0 is p = 0 and lies at the bottom. */
  paint() {
    const colours = ramp(isDark());
    for (const { figure, bytes, columns, rows } of this.all)
      paintCells(/** @type {HTMLCanvasElement} */ (figure.querySelector("canvas")), columns, rows, (x, y) => {
        const strength = Math.sqrt(bytes[(rows - 1 - y) * columns + x] / 255);
        return colours[Math.round(255 * strength)];
      });
  }

  /** @param {number} stop */
  mark(stop) {
    for (const { figure, bytes, columns, rows, colour } of this.all) {
      const [cursor, canvas] = /** @type {any} */ (figure.querySelectorAll(".cursor, .profile"));
      cursor.style.top = `${(100 * (rows - 0.5 - stop)) / rows}%`;
      [canvas.width, canvas.height] = [2 * columns, 90];
      const x = drawingOn(canvas);
      x.fillStyle = colour;
      for (let column = 0; column < columns; column++) {
        const high = (bytes[stop * columns + column] / 255) * (canvas.height - 4);
        x.fillRect(2 * column, canvas.height - high, 2, high);
      }
    }
  }
}

/** A sentence about the weights. @param {number} count @param {number} scale the largest distance of a weight from
 * 1/count */
export function about(count, scale) {
  const points = (100 * scale).toPrecision(2);
  const even = percent(1 / count, 1);
  return scale < WORTH
    ? `Nothing to see: each of the ${count} tokens gets the uniform ${even}, within ${points} points, at every p.`
    : `Rows attend to columns, over ${count} tokens (real parts, then imaginary). Uniform: ${even}. Orange is more, ` +
        `blue is less; full colour is ${points} points.`;
}

/** Attention among the tokens of one modality; a sentence replaces a uniform one. */
export class Attention extends View {
  /** @type {{count: number, bytes: Int8Array, canvas: HTMLCanvasElement}[]} */
  all = [];
  stop = 0;

  /** @param {Attended | null} reply @param {string} problem why there is none */
  show(reply, problem = "") {
    const there = reply ? imagesOf(reply.off) : [];
    const words = reply ? about(reply.count[there[0]], reply.scale) : problem;
    const shown = reply && reply.scale >= WORTH ? there : [];
    const figures = shown.map(
      (name) =>
        html`<figure><figcaption>${signed(name, TERMS[name].title)}</figcaption>
          <canvas class="square" role="img" aria-label="Attention of each token of the ${TERMS[name].one} to each, at
          this p"></canvas></figure>`,
    );
    put(this.box, html`${words && hint(words)}${figures}`);
    const canvases = this.box.querySelectorAll("canvas");
    this.all = shown.map((name, i) => ({
      count: reply?.count[name] ?? 0,
      bytes: new Int8Array(bytesOf(reply?.off[name] ?? "").buffer),
      canvas: canvases[i],
    }));
    this.mark(this.stop);
  }

  /** From −1 (blue) to 1 (orange); 0 is paper. */
  mark(stop = this.stop) {
    this.stop = stop;
    const paper = rgb(isDark() ? "#0f172a" : "#ffffff");
    for (const { count, bytes, canvas } of this.all)
      paintCells(canvas, count, count, (x, y) => {
        const v = bytes[(stop * count + y) * count + x] / 127;
        const ink = v > 0 ? MORE : LESS;
        return paper.map((from, c) => Math.round(from + (ink[c] - from) * Math.abs(v)));
      });
  }
}
