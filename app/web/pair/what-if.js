/** What if p were different: the same weights at other orders. */

import { ask, attempt } from "../shared/api.js";
import { nearest, orderText } from "../shared/frames.js";
import { HUNDREDTHS, orderBar } from "../shared/order.js";
import { treeSvg } from "../shared/pair-tree.js";
import { radios } from "../shared/radios.js";
import { change, state } from "../shared/store.js";
import { sensorOf } from "../shared/tables.js";
import { onClick, View } from "../shared/view.js";
import { Lines } from "./lines.js";
import { draw, html, percent, titleOf } from "./parts.js";
import { Attention, Spectra } from "./rasters.js";
import { readingsOf } from "./verdict.js";

export class WhatIf extends View {
  /** What was drawn last: the tab, to draw at another p, and the prediction whose pictures are on the canvases.
   * @type {PairTab | null} */
  tab = null;
  /** @type {Predicted | null} */
  drawn = null;

  /** @param {HTMLDetailsElement} box @param {(reading: Reading) => void} choose */
  constructor(box, choose) {
    super(box);
    this.bar = orderBar(this.$(".order-bar"));
    this.lines = new Lines(this.$(".lines"), (p) => change({ p }));
    this.spectra = new Spectra(this.$(".pictures"));
    this.attention = new Attention(this.$(".looks"));
    box.ontoggle = () => this.show();
    onClick(this.$(".which"), { button: ({ dataset }) => choose(dataset.key) });
  }

  /** Show the prediction of the tab at the present p; nothing without one. What is folded away is not drawn.
   * @param {PairTab | null} tab */
  show(tab = this.tab) {
    this.tab = tab;
    this.box.hidden = !tab?.moving;
    if (!tab?.moving || !this.box.open) return;
    const { set, curves, journey } = tab;
    const { answer, question } = tab.moving;
    const { classes, stops, learned, span, spectra, images } = answer;
    const stop = HUNDREDTHS.stop(state.p);
    this.bar.show(stop);
    if (answer !== this.drawn) {
      this.drawn = answer;
      this.bar.learned(learned);
      this.$(".about-p").textContent = aboutP(answer, tab.answer?.linear ? tab.source : "");
      this.spectra.show(spectra);
      this.look(question);
    }
    const readings = Object.fromEntries(Object.entries(stops).map(([name, rows]) => [name, rows[stop]]));
    const all = readingsOf({ classes, readings, images }).filter(({ label }) => label);
    const { reading, label, share, guess } = all.find((said) => said.reading === curves) ?? all[0];
    const p = HUNDREDTHS.orders[stop];
    const choices = all.map((said) => ({ key: said.reading, label: titleOf(said.reading) }));
    draw(this.$(".which"), radios(choices, reading));
    this.lines.show({ classes, p, rows: stops[reading], learned, band: band(span, set?.frames?.fits) });
    for (const one of [this.spectra, this.attention]) one.mark(stop);
    const words = guess
      ? html`<b>${label}?</b> This is a guess at every p, because an image is unlike all training images.`
      : html`<b>${label} ${percent(share)}</b>.`;
    const at = journey ? nearest(journey.orders, p) : -1;
    this.$(".tree-at-p").hidden = !journey?.tree.parents.length;
    if (journey?.tree.parents.length)
      draw(
        this.$(".tree-now"),
        html`${treeSvg(journey, at)}<p class="hint">At p = ${orderText(journey.orders[at])}: what each
          node alone predicts.</p>`,
      );
    draw(this.$(".at-p"), html`With p = ${p.toFixed(2)}, ${titleOf(reading).toLowerCase()}: ${words}`);
  }

  /** @param {Question} question */
  async look(question) {
    const { drawn } = this;
    /** @type {Attention["show"]} */
    const show = (...reply) => this.drawn === drawn && this.attention.show(...reply);
    show(null);
    await attempt(
      async () => show(await ask("attention", question)),
      (/** @type {string} */ problem) => show(null, problem),
    );
  }

  repaint() {
    this.spectra.paint();
    this.show();
  }
}

/** The orders that a head was trained for, as a band on the axis of p: the `span` that training drew p from, or
 * what `fits` a learned p (from the frames; null before they are known, and then there is no band).
 * @param {number[]} span @param {number[] | null} [fits] @returns {[number, number] | null} */
export function band(span, fits) {
  const [low, high] = (span[1] > span[0] ? span : fits) ?? [NaN, NaN];
  return low <= high ? [Math.max(0, low), Math.min(1, high)] : null;
}

/** The meaning of moving p for this head. `source`: what the head of the chapters learned from, where it takes the
 * place of linear maps. @param {Pick<Predicted, "learned" | "span" | "classes" | "linear">} answer */
export function aboutP({ learned, span, classes, linear }, source = "") {
  if (linear) return "Linear maps of the embeddings decide here, and p has no part in them: every curve is flat.";
  const whose = source
    ? "The prediction above comes from linear maps, in which p has no part. Here the head of the chapters reads this " +
      `pair; it was trained on ${sensorOf(source)} alone. `
    : "";
  const [low, high] = span;
  return high > low
    ? `${whose}This head was trained for all values of p from ${low.toFixed(2)} to ${high.toFixed(2)} (shaded).`
    : `${whose}The weights stay those of the learned p = ${learned.toFixed(3)}. The shaded band shows the values of ` +
        "p that this head was trained for. Outside it the weights do not fit: predictions are little better than " +
        `chance (${percent(1 / classes.length)}), so a rise or fall means little. Explore shows heads trained at each
p.`;
}
