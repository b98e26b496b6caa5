/** Small line charts over epochs. */

import { Scale } from "../shared/chart.js";
import { TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { html, percent } from "../shared/text.js";

const W = 300; // unless the width of the box is known; text keeps its size
const H = 120;
const PAD = { left: 54, right: 8, top: 8, bottom: 18 };
const [BLUE, ORANGE, GREEN, GREY, RED] = ["#2f7fd1", "#d55e00", "#009e73", "#8c8c8c", "#b91c1c"];

/** @typedef {{name: string, colour: string, points: number[][], dashed?: string}} Series */
/** What is drawn around the lines: `at` is the epoch that is marked, `total` epochs in all; sizes in CSS pixels; `top` of
 * the axis, computed by default; `level`: a dotted line, of shares.
 * @typedef {{at: number, total: number, wide?: number, tall?: number, top?: number, level?: number}} Frame */

/** The charts of a run: title, lines by the name of their value, what the axis shows.
 * @type {[title: string, lines: [name: string, colour: string, key: string, dashed?: string][], axis?: "share" | "p"][]} */
const CHARTS = [
  [
    "Loss",
    [
      ["total", BLUE, "loss"],
      ["cross-entropy", ORANGE, "cross_entropy"],
    ],
  ],
  [
    "Accuracy",
    [
      ["unseen domains", BLUE, "accuracy/unseen"],
      ["source test", GREY, "accuracy/source_test", "4 3"],
    ],
    "share",
  ],
  [
    "Unseen domains, one image",
    [
      ["photo only", VIS_COLOUR, "accuracy:vis/unseen"],
      ["touch only", TAC_COLOUR, "accuracy:tac/unseen"],
    ],
    "share",
  ],
  [
    "Gaps of F̂",
    [
      ["modality", ORANGE, "modality_gap/f_hat"],
      ["domain", GREEN, "domain_gap/f_hat"],
    ],
  ],
  ["Cosine margin of F̂", [["margin", GREEN, "margin/f_hat"]]],
  ["p", [["p", RED, "order"]], "p"],
];

/** A round upper limit of an axis. @param {number} value */
export function niceTop(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 2.5, 5].map((m) => m * power).find((top) => top >= value) ?? 10 * power;
}

/** @param {string} title @param {Series[]} series @param {Frame} frame */
export function chart(title, series, { at, total, wide = W, tall = H, top, level }) {
  const high = top ?? niceTop(Math.max(0.001, ...series.flatMap(({ points }) => points.map(([, v]) => v))));
  const scale = new Scale({ wide, high: tall, pad: PAD, xs: [1, Math.max(2, total)], ys: [0, high] });
  /** @param {number} v */
  const figure = (v) => (level ? percent(v) : `${+v.toFixed(2)}`);
  const key = series.map(({ name, colour, points }) => {
    const value = points.findLast(([epoch]) => epoch <= at)?.[1];
    const words = value === undefined ? "–" : level ? percent(value, 1) : value.toFixed(3);
    return html`<span><i style="background:${colour}"></i>${name} <b>${words}</b></span>`;
  });
  const lines = series.map(
    ({ colour, points, dashed = "none" }) =>
      html`<path d="${scale.line(points)}" style="stroke:${colour}" stroke-dasharray="${dashed}"/>`,
  );
  const ends = [
    [1, 1],
    [scale.xs[1], total],
  ];
  return html`<figure><figcaption>${title}</figcaption>${scale.svg(`${title} over epochs`, scale.grid([0, high / 2, high], figure), level && scale.across("chance", level), lines, scale.now(at), scale.ticks(ends, 3))}<p class="now-values">${key}</p></figure>`;
}

/** The charts of a run, for a number of classes; once anything is measured, only those with values.
 * @param {Epoch[]} epochs @param {number} classes @param {Frame} frame */
export function charts(epochs, classes, frame, bare = false) {
  const all = CHARTS.map(([title, lines, axis]) => ({
    title,
    top: axis && 1,
    level: axis === "share" ? 1 / classes : undefined,
    series: lines.map(([name, colour, key, dashed]) => {
      const points = epochs.flatMap(({ epoch, measures, ...more }) => {
        /** @type {Record<string, unknown>} */
        const values = { ...measures, ...more };
        const value = values[key];
        return typeof value === "number" ? [[epoch, value]] : [];
      });
      return { name, colour, dashed, points };
    }),
  }));
  const known = bare || epochs.some(({ measures }) => Object.keys(measures).length);
  const shown = known ? all.filter(({ series }) => series.some(({ points }) => points.length)) : all;
  const tall = bare ? 2 * H : H;
  return html`${shown.map(({ title, series, ...axis }) => chart(title, series, { ...frame, ...axis, tall }))}`;
}
