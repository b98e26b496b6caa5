/** Small line charts over epochs. Values in, SVG text out. */

import { Scale } from "../shared/chart.js";
import { TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { each } from "../shared/text.js";

const W = 300; // unless the width of the box is known; text keeps its size then
const H = 120;
const PAD = { left: 46, right: 8, top: 8, bottom: 18 };

/** A round upper limit of an axis. */
export function niceTop(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 2.5, 5].map((m) => m * power).find((top) => top >= value) ?? 10 * power;
}

/**
 * series: [{name, colour, points: [[epoch, value]], dashed}]; top: of the axis, computed by default;
 * low: its lower end; wide, tall: in CSS pixels; at: the epoch that is marked; total: epochs in all; unit: "%" shows shares.
 */
export function chart({ title, series, total, at, top = null, low = 0, level = null, unit = "", wide = W, tall = H }) {
  const values = series.flatMap((one) => one.points.map(([, v]) => v)).filter(Number.isFinite);
  const high = top ?? niceTop(Math.max(0.001, ...values));
  const scale = new Scale({ wide, high: tall, pad: PAD, xs: [1, Math.max(2, total)], ys: [low, high] });
  const figure = (v) => (unit === "%" ? `${Math.round(100 * v)} %` : `${+v.toFixed(2)}`);
  const lines = each(
    series,
    ({ colour, points, dashed }) =>
      `<path d="${scale.line(points)}" style="stroke:${colour}" ${dashed ? 'stroke-dasharray="4 3"' : ""}/>`,
  );
  const chance =
    level === null
      ? ""
      : `<line class="chance" x1="${scale.left}" x2="${scale.right}" y1="${scale.y(level)}" y2="${scale.y(level)}"/>`;
  const now = each(series, ({ name, colour, points }) => {
    const last = points.findLast(([epoch]) => epoch <= at);
    return `<span><i style="background:${colour}"></i>${name} <b>${last ? (unit === "%" ? `${(100 * last[1]).toFixed(1)} %` : last[1].toFixed(3)) : "–"}</b></span>`;
  });
  return `<figure><figcaption>${title}</figcaption><svg viewBox="0 0 ${wide} ${tall}" role="img" aria-label="${title} over epochs">${scale.grid([low, (low + high) / 2, high], figure)}${chance}${lines}<line class="now" x1="${scale.x(at)}" x2="${scale.x(at)}" y1="${scale.top}" y2="${scale.base}"/>${scale.ticks(
    [
      [1, 1],
      [scale.xs[1], total],
    ],
    3,
  )}</svg><p class="now-values">${now}</p></figure>`;
}

/** The charts of a run; once anything is measured, only those with values. classes: for the chance line; wide: of a
 * chart, in CSS pixels; bare: only those with values. */
export function charts(epochs, total, at, classes, wide = W, bare = false) {
  const of = (read) => epochs.map((one) => [one.epoch, read(one)]).filter(([, v]) => Number.isFinite(v));
  const [blue, orange, green, grey] = ["#2f7fd1", "#d55e00", "#009e73", "#8c8c8c"];
  const shares = { top: 1, unit: "%", level: 1 / classes };
  const line = (name, colour, read, dashed = false) => ({ name, colour, points: of(read), dashed });
  const measured = (name, colour, key, dashed = false) => line(name, colour, (one) => one.measures[key], dashed);
  const all = [
    {
      title: "Loss",
      series: [line("total", blue, (one) => one.loss), line("cross-entropy", orange, (one) => one.cross_entropy)],
    },
    {
      title: "Accuracy",
      ...shares,
      series: [
        measured("unseen domains", blue, "accuracy/unseen"),
        measured("source test", grey, "accuracy/source_test", true),
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
    { title: "p", top: 1, series: [line("p", "#b91c1c", (one) => one.order)] },
  ];
  const known = bare || epochs.some((one) => Object.keys(one.measures).length);
  const shown = known ? all.filter(({ series }) => series.some(({ points }) => points.length)) : all;
  return each(shown, (one) => chart({ ...one, total, at, wide, tall: bare ? 2 * H : H }));
}
