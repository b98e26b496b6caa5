/** What if p were different: the same weights at other orders. */

import { ask, attempt } from "../shared/api.js";
import { HUNDREDTHS, orderBar } from "../shared/order.js";
import { radios } from "../shared/radios.js";
import { change, state } from "../shared/store.js";
import { draw, html, percent, put } from "../shared/text.js";
import { onClick, View } from "../shared/view.js";
import { Lines } from "./lines.js";
import { Attention, Spectra } from "./rasters.js";
import { readingsOf, titleOf } from "./verdict.js";

export class WhatIf extends View {
  /** @param {HTMLDetailsElement} box */
  constructor(box) {
    super(box);
    this.details = box;
    /** @type {PairTab | null} */
    this.tab = null;
    /** @type {Reading} */
    this.reading = "fused";
    this.bar = orderBar(this.$(".order-bar"));
    this.lines = new Lines(this.$(".lines"), (p) => change({ p }));
    this.spectra = new Spectra(this.$(".pictures"));
    this.attention = new Attention(this.$(".looks"));
    /** @type {Question | null} */
    this.looked = null; // the request whose attention is shown
    box.ontoggle = () => this.paint();
    onClick(this.$(".which"), {
      button: ({ dataset }) => {
        this.reading = dataset.key;
        this.paint();
      },
    });
  }

  /** Show the prediction of the tab; nothing without one. @param {PairTab} tab */
  show(tab) {
    const before = this.tab;
    this.tab = tab;
    const { answer } = tab;
    this.box.hidden = !answer;
    if (!answer) return;
    if (answer !== before?.answer) {
      if (state.p === null) state.p = answer.learned;
      this.bar.learned(answer.learned);
      this.$(".about-p").textContent = aboutP(answer);
    }
    if (answer !== before?.answer || tab.set !== before.set) this.paint();
    else if (tab.familiar !== before.familiar) this.mark();
  }

  /** What the readings say at a stop. @param {Predicted} answer @param {number} stop */
  at({ classes, stops }, stop) {
    const readings = Object.fromEntries(Object.entries(stops).map(([name, rows]) => [name, rows[stop]]));
    return readingsOf({ classes, readings, images: this.tab?.familiar?.images }).filter(({ label }) => label);
  }

  /** Draw only while the section is open. */
  paint() {
    const { answer, question } = this.tab ?? {};
    if (!answer || !question || !this.details.open) return;
    const there = this.at(answer, 0).map(({ reading }) => reading);
    if (!there.includes(this.reading)) [this.reading] = there;
    const readings = there.map((key) => ({ key, label: titleOf(key) }));
    draw(this.$(".which"), radios(readings, this.reading));
    this.spectra.show(answer.spectra);
    this.look(question);
    this.mark();
  }

  /** @param {Question} question */
  async look(question) {
    if (this.looked === question) return;
    this.looked = question;
    /** @type {Attention["show"]} */
    const show = (...reply) => this.looked === question && this.attention.show(...reply);
    show(null);
    await attempt(
      async () => show(await ask("attention", question)),
      (/** @type {string} */ problem) => show(null, problem),
    );
  }

  /** Show the current p. */
  mark() {
    const { answer, set } = this.tab ?? {};
    if (!answer || state.p === null) return;
    const stop = HUNDREDTHS.stop(state.p);
    this.bar.show(stop);
    if (!this.details.open) return;
    const { classes, stops, learned, span } = answer;
    const p = HUNDREDTHS.orders[stop];
    this.lines.show({ classes, p, rows: stops[this.reading], learned, band: band(span, set?.frames?.fits) });
    for (const one of [this.spectra, this.attention]) one.mark(stop);
    const [said] = this.at(answer, stop).filter(({ reading }) => reading === this.reading);
    const words = said.guess
      ? html`<b>${said.label}?</b> A guess at every p, because an image is unlike anything seen.`
      : html`<b>${said.label} ${percent(said.share)}</b>.`;
    put(this.$(".at-p"), html`With p = ${p.toFixed(2)}, ${titleOf(this.reading).toLowerCase()}: ${words}`);
  }

  repaint() {
    this.spectra.paint();
    this.attention.mark();
    this.mark();
  }
}

/** The orders that a head was trained for, as a band on the axis of p: the `span` that training drew p from, or
 * what `fits` a learned p (from the frames; null before they are known, and then there is no band).
 * @param {number[]} span @param {number[] | null} [fits] @returns {[number, number] | null} */
export function band(span, fits) {
  const [low, high] = (span[1] > span[0] ? span : fits) ?? [NaN, NaN];
  return low <= high ? [Math.max(0, low), Math.min(1, high)] : null;
}

/** The meaning of moving p for this head. @param {Pick<Predicted, "learned" | "span" | "classes" | "linear">} answer */
export function aboutP({ learned, span, classes, linear }) {
  if (linear) return "Linear maps of the embeddings decide here, and p has no part in them: every curve is flat.";
  if (span[1] > span[0])
    return `This head was trained for every p from ${span[0].toFixed(2)} to ${span[1].toFixed(2)} (shaded).`;
  return `Weights stay those of the learned p = ${learned.toFixed(3)}. Shaded: the orders this head was trained for. Elsewhere the weights do not fit, and predictions are little better than guessing (${percent(1 / classes.length)}), so a rise or fall there means little. Explore shows heads trained at each p.`;
}
