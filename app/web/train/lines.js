/** Small line charts over epochs. */

import { Scale } from "../shared/chart.js";
import { TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { html } from "../shared/text.js";

const W = 300; // unless the width of the box is known; text keeps its size then
const H = 120;
const PAD = { left: 46, right: 8, top: 8, bottom: 18 };

/** @typedef {{name: string, colour: string, points: number[][], dashed?: boolean}} Series */
/**
 * Lines over epochs: `top` of the axis, computed by default; `level`: a dotted line, of shares.
 * @typedef {{title: string, series: Series[], top?: number, level?: number}} Chart
 */
/** What all charts share: `at` is the epoch that is marked, `total` epochs in all; sizes in CSS pixels.
 * @typedef {{at: number, total: number, wide?: number, tall?: number}} Frame */

/** A round upper limit of an axis. @param {number} value */
export function niceTop(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 2.5, 5].map((m) => m * power).find((top) => top >= value) ?? 10 * power;
}

/** @param {Chart} chart @param {Frame} frame */
export function chart({ title, series, top, level }, { at, total, wide = W, tall = H }) {
  const values = series.flatMap(({ points }) => points.map(([, v]) => v));
  const high = top ?? niceTop(Math.max(0.001, ...values));
  const scale = new Scale({ wide, high: tall, pad: PAD, xs: [1, Math.max(2, total)], ys: [0, high] });
  /** @param {number} v */
  const figure = (v) => (level ? `${Math.round(100 * v)} %` : `${+v.toFixed(2)}`);
  const key = series.map(({ name, colour, points }) => {
    const value = points.findLast(([epoch]) => epoch <= at)?.[1];
    const words = value === undefined ? "–" : level ? `${(100 * value).toFixed(1)} %` : value.toFixed(3);
    return html`<span><i style="background:${colour}"></i>${name} <b>${words}</b></span>`;
  });
  return html`<figure><figcaption>${title}</figcaption><svg viewBox="0 0 ${wide} ${tall}" role="img" aria-label="${title} over epochs">${scale.grid([0, high / 2, high], figure)}${level && scale.across("chance", level)}${series.map(
    ({ colour, points, dashed }) =>
      html`<path d="${scale.line(points)}" style="stroke:${colour}"${dashed && html` stroke-dasharray="4 3"`}/>`,
  )}${scale.now(at)}${scale.ticks(
    [
      [1, 1],
      [scale.xs[1], total],
    ],
    3,
  )}</svg><p class="now-values">${key}</p></figure>`;
}

/** The charts of a run, for a number of classes; once anything is measured, only those with values.
 * @param {Epoch[]} epochs @param {number} classes @param {Frame} frame */
export function charts(epochs, classes, frame, bare = false) {
  const [blue, orange, green, grey] = ["#2f7fd1", "#d55e00", "#009e73", "#8c8c8c"];
  const shares = { top: 1, level: 1 / classes };
  /** @param {string} name @param {string} colour @param {(epoch: Epoch) => number} read */
  const line = (name, colour, read) => {
    const points = epochs.map((epoch) => [epoch.epoch, read(epoch)]);
    return { name, colour, points: points.filter(([, v]) => Number.isFinite(v)) };
  };
  /** @param {string} name @param {string} colour @param {string} key */
  const measured = (name, colour, key) => line(name, colour, ({ measures }) => measures[key]);
  /** @type {Chart[]} */
  const all = [
    {
      title: "Loss",
      series: [line("total", blue, ({ loss }) => loss), line("cross-entropy", orange, (one) => one.cross_entropy)],
    },
    {
      title: "Accuracy",
      ...shares,
      series: [
        measured("unseen domains", blue, "accuracy/unseen"),
        { ...measured("source test", grey, "accuracy/source_test"), dashed: true },
      ],
    },
    {
      title: "Unseen domains, one image",
      ...shares,
      series: [
        measured("photo only", VIS_COLOUR, "accuracy:vis/unseen"),
        measured("touch only", TAC_COLOUR, "accuracy:tac/unseen"),
      ],
    },
    {
      title: "Gaps of F̂",
      series: [measured("modality", orange, "modality_gap/f_hat"), measured("domain", green, "domain_gap/f_hat")],
    },
    { title: "Cosine margin of F̂", series: [measured("margin", green, "margin/f_hat")] },
    { title: "p", top: 1, series: [line("p", "#b91c1c", ({ order }) => order)] },
  ];
  const known = bare || epochs.some(({ measures }) => Object.keys(measures).length);
  const shown = known ? all.filter(({ series }) => series.some(({ points }) => points.length)) : all;
  return html`${shown.map((one) => chart(one, { ...frame, tall: bare ? 2 * H : H }))}`;
}
