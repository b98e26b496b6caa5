/** One chirp, turned by the slider: long at most orders, one spike at its own. */

import { attempt } from "../shared/api.js";
import { Scale } from "../shared/chart.js";
import { toyFacts } from "../shared/facts.js";
import { nearest } from "../shared/frames.js";
import { View } from "../shared/view.js";

const SCALE = new Scale({ wide: 300, high: 74, pad: { left: 2, right: 2, top: 6, bottom: 4 } });

/** The sizes of a signal's samples, from their real and imaginary parts. */
export const sizes = ({ re, im }, stop) => re[stop].map((v, k) => Math.hypot(v, im[stop][k]));

export class Wave extends View {
  /** Draw the stop nearest to p; the first call fetches the signal. */
  async show(p) {
    await attempt(async () => {
      const { orders, signals } = await toyFacts();
      const all = sizes(signals.vis, nearest(orders, p));
      const line = SCALE.line(all.map((v, k) => [k / (all.length - 1), v]));
      this.box.innerHTML = `<svg viewBox="0 0 300 74" preserveAspectRatio="none" role="img" aria-label="One chirp, turned by p: its sharpest sample has ${Math.max(...all).toFixed(2)} of 1"><path d="${line}"/></svg>`;
    }, this.box);
  }
}
