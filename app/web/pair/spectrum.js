/** |F_p| over p as a picture, the current p marked, and its profile beneath. */

import { isDark, ramp, TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { bytesOf } from "../shared/text.js";

const COLOURS = { vis: VIS_COLOUR, tac: TAC_COLOUR };
const NAMES = { vis: "● VIS", tac: "▲ TAC" };

export class Spectra {
  constructor(box) {
    this.box = box;
    this.all = [];
  }

  show(spectra) {
    this.box.innerHTML = Object.keys(spectra)
      .map(
        (name) => `<figure><figcaption>${NAMES[name]}</figcaption>
      <div class="heat"><span class="up">p</span><canvas role="img" aria-label="Spectrum of ${NAMES[name]} over p"></canvas><i class="cursor"></i></div>
      <canvas class="profile" role="img" aria-label="Spectrum of ${NAMES[name]} at the current p"></canvas>
      <p class="scale"><span>entry 0</span><span>${spectra[name].width} entries · brightest = ${spectra[name].top.toPrecision(3)}</span><span>${spectra[name].width - 1}</span></p></figure>`,
      )
      .join("");
    this.all = Object.entries(spectra).map(([name, s], i) => ({
      ...s,
      name,
      bytes: bytesOf(s.pixels),
      figure: this.box.querySelectorAll("figure")[i],
    }));
    this.paint();
  }

  /** Row 0 is p = 0 and lies at the bottom. */
  paint() {
    const colours = ramp(isDark());
    for (const one of this.all) {
      const canvas = one.figure.querySelector("canvas");
      canvas.width = one.columns;
      canvas.height = one.rows;
      const image = new ImageData(one.columns, one.rows);
      for (let row = 0; row < one.rows; row++) {
        for (let column = 0; column < one.columns; column++) {
          const at = 4 * ((one.rows - 1 - row) * one.columns + column);
          const strength = Math.sqrt(one.bytes[row * one.columns + column] / 255);
          image.data.set([...colours[Math.round(255 * strength)], 255], at);
        }
      }
      canvas.getContext("2d").putImageData(image, 0, 0);
    }
  }

  mark(stop) {
    for (const one of this.all) {
      const share = (one.rows - 0.5 - stop) / one.rows;
      one.figure.querySelector(".cursor").style.top = `${100 * share}%`;
      const canvas = one.figure.querySelector(".profile");
      const width = (canvas.width = 2 * one.columns);
      const height = (canvas.height = 90);
      const x = canvas.getContext("2d");
      x.fillStyle = COLOURS[one.name];
      for (let column = 0; column < one.columns; column++) {
        const v = (one.bytes[stop * one.columns + column] / 255) * (height - 4);
        x.fillRect((column * width) / one.columns, height - v, 2, v);
      }
    }
  }
}
