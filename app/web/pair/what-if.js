/** What if p were different: the same weights at other orders. */

import { ask, attempt } from "../shared/api.js";
import { imagesOf } from "../shared/images.js";
import { orderBar } from "../shared/order.js";
import { radios } from "../shared/radios.js";
import { change, state } from "../shared/store.js";
import { escaped, percent } from "../shared/text.js";
import { theSet } from "../shared/theset.js";
import { View } from "../shared/view.js";
import { Lines } from "./lines.js";
import { Attention, Spectra } from "./rasters.js";
import { best, READINGS, unlike } from "./verdict.js";

const STOPS = Array.from({ length: 101 }, (_, i) => i / 100);
/** A scale for the order bar; there is no learned p before the server's reply. */
const scale = (answer) => ({
  orders: answer?.orders ?? STOPS,
  meta: { head: { learned_order: answer?.learned } },
  stop: (p) => Math.max(0, Math.min(100, Math.round(100 * p))),
});

export class WhatIf extends View {
  constructor(box) {
    super(box);
    this.answer = null;
    this.reading = "fused";
    this.bar = orderBar(this.$(".order-bar"), scale(null));
    this.lines = new Lines(this.$(".lines"), (p) => change({ p }));
    this.spectra = new Spectra(this.$(".pictures"));
    this.attention = new Attention(this.$(".looks"));
    this.looked = null; // the request whose attention is shown
    box.addEventListener("toggle", () => this.paint());
    this.fits = null; // the orders that the set's head was trained for
    theSet().then(
      ({ frames }) => {
        this.fits = frames.fits;
        this.paint();
      },
      () => {}, // Explore shows the reason
    );
  }

  /** answer: the pair's predictions; question: their request. null clears. */
  show(answer, question) {
    this.answer = answer;
    this.question = question;
    this.images = null; // familiarity of each image
    this.box.hidden = !answer;
    if (!answer) return;
    if (!answer.stops[this.reading]) this.reading = "fused";
    if (state.p === null) state.p = answer.learned;
    this.bar.replace(scale(answer));
    this.bar.learned(answer.learned);
    this.$(".about-p").textContent = aboutP(answer);
    this.paint();
  }

  /** The familiarity of the images has arrived. */
  know(images) {
    this.images = images;
    this.mark();
  }

  /** Draw only while the section is open. */
  paint() {
    if (!this.answer || !this.box.open) return;
    const { classes, orders, stops, learned, span, spectra } = this.answer;
    const there = READINGS.filter(
      ([reading]) => stops[reading] && !(reading === "fused" && Object.keys(stops).length < 3),
    );
    if (!there.some(([reading]) => reading === this.reading)) this.reading = there[0][0];
    radios(
      this.$(".which"),
      there.map(([key, label]) => ({ key, label })),
      () => this.reading,
      (reading) => {
        this.reading = reading;
        this.paint();
      },
    );
    this.lines.show(classes, orders, stops[this.reading], learned, band(span, this.fits));
    this.spectra.show(spectra);
    this.look();
    this.mark();
  }

  async look() {
    const { question } = this;
    if (this.looked === question) return;
    this.looked = question;
    this.attention.show(null);
    await attempt(
      async () => {
        const found = await ask("attention", question);
        if (this.question === question) this.attention.show(found);
      },
      (sentence) => this.attention.show({ problem: sentence }),
    );
    this.mark();
  }

  /** Show the current p. */
  mark() {
    if (!this.answer || state.p === null) return;
    const stop = scale(this.answer).stop(state.p);
    this.bar.show(stop);
    if (!this.box.open) return;
    const { classes, orders, stops } = this.answer;
    this.lines.mark(stop, orders);
    this.spectra.mark(stop);
    this.attention.mark(stop);
    const title = READINGS.find(([reading]) => reading === this.reading)?.[1].toLowerCase();
    const { label, share } = best(classes, stops[this.reading][stop]);
    const given = imagesOf(stops);
    const at = `With p = ${orders[stop].toFixed(2)}, ${title}: `;
    this.$(".at-p").innerHTML = unlike(this.reading, given, this.images).length
      ? `${at}<b>${escaped(label)}?</b> A guess at every p, because an image is unlike anything seen.`
      : `${at}<b>${escaped(label)} ${percent(share)}</b>.`;
  }

  repaint() {
    this.spectra.paint();
    this.attention.mark();
    this.mark();
  }
}

/** The orders that a head was trained for, as a band on the axis of p: the `span` that training drew p from, or
 * what `fits` a learned p (from the frames; null before they are known, and then there is no band). */
export function band(span, fits) {
  const [low, high] = (span[1] > span[0] ? span : fits) ?? [NaN, NaN];
  return low <= high ? [Math.max(0, low), Math.min(1, high)] : null;
}

/** The meaning of moving p for this head. */
export function aboutP({ learned, span, classes, linear }) {
  if (linear) return "Linear maps of the embeddings decide here, and p has no part in them: every curve is flat.";
  const chance = percent(1 / classes.length);
  if (span[1] > span[0]) {
    return `This head was trained for every p from ${span[0].toFixed(2)} to ${span[1].toFixed(2)} (shaded).`;
  }
  return `Weights stay those of the learned p = ${learned.toFixed(3)}. Shaded: the orders this head was trained for. Elsewhere the weights do not fit, and predictions are little better than guessing (${chance}), so a rise or fall there means little. Explore shows heads trained at each p.`;
}
