/** Accuracy and both gaps against p in one chart, each with its value at the present stop. */

import { dragged, Scale } from "../shared/chart.js";
import { asText, values } from "../shared/measures.js";
import { each } from "../shared/text.js";
import { View } from "../shared/view.js";

const LINES = [
  ["accuracy", "accuracy"],
  ["modality_gap", "modality gap"],
  ["domain_gap", "domain gap"],
];
const HIGH = 112; // CSS pixels
const PAD = { left: 54, right: 10, top: 8, bottom: 24 }; // as in curves.js, above the same slider

export class Together extends View {
  /** `onOrder(p)`: a click or drag on the chart. */
  constructor(box, onOrder) {
    super(box);
    /** @type {any} */
    this.frames = null;
    this.stop = 0;
    this.scale = new Scale({ wide: 300, high: HIGH, pad: PAD });
    dragged(box, (event, svg) => onOrder(this.scale.under(event, svg)));
    new ResizeObserver(
      () => this.frames && this.box.clientWidth !== this.scale.wide && this.replace(this.frames),
    ).observe(box);
  }

  replace(frames) {
    this.frames = frames;
    const scale = (this.scale = new Scale({ wide: Math.max(150, this.box.clientWidth), high: HIGH, pad: PAD }));
    const line = ([name]) => {
      const known = values(frames, name, "f_hat");
      return known ? `<path class="${name}" d="${scale.line(frames.orders.map((p, i) => [p, known[i]]))}"/>` : "";
    };
    const key = each(LINES, ([name, title]) => `<span class="${name}">${title} <output></output></span>`);
    this.box.innerHTML = `<p class="key">${key}</p><svg viewBox="0 0 ${scale.wide} ${HIGH}" role="img" aria-label="Accuracy and both gaps against p">${scale.grid([0, 1], String)}${scale.now()}${each(LINES, line)}</svg>`;
    this.mark(this.stop);
  }

  mark(stop) {
    this.stop = stop;
    if (!this.frames) return;
    this.scale.mark(this.box, this.frames.orders[stop]);
    for (const [name] of LINES)
      this.$(`.key .${name} output`).textContent = asText(name, values(this.frames, name, "f_hat")?.[stop], 2);
  }
}
