/** Small line charts over epochs. Values in, SVG text out. */

const W = 300; // unless the width of the box is known; text keeps its size then
const H = 120;
const PAD = { left: 38, right: 8, top: 8, bottom: 18 };

/** A round upper limit of an axis. */
export function niceTop(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 2.5, 5, 10].map((m) => m * power).find((top) => top >= value);
}

/**
 * series: [{name, colour, points: [[epoch, value]], dashed}]; top: of the axis, computed by default;
 * low: its lower end; wide, tall: in CSS pixels; at: the epoch that is marked; total: epochs in all; unit: "%" shows shares.
 */
export function chart({ title, series, total, at, top = null, low = 0, level = null, unit = "", wide = W, tall = H }) {
  const values = series.flatMap((one) => one.points.map(([, v]) => v)).filter(Number.isFinite);
  const high = top ?? niceTop(Math.max(0.001, ...values));
  const X = (epoch) => PAD.left + ((epoch - 1) / Math.max(1, total - 1)) * (wide - PAD.left - PAD.right);
  const Y = (v) => tall - PAD.bottom - ((v - low) / (high - low)) * (tall - PAD.top - PAD.bottom);
  const figure = (v) => (unit === "%" ? `${Math.round(100 * v)} %` : `${+v.toFixed(2)}`);
  const grid = [low, (low + high) / 2, high].map(
    (v) =>
      `<line class="grid" x1="${PAD.left}" x2="${wide - PAD.right}" y1="${Y(v)}" y2="${Y(v)}"/><text x="${PAD.left - 5}" y="${Y(v) + 4}" text-anchor="end">${figure(v)}</text>`,
  );
  const lines = series.map(({ colour, points, dashed }) => {
    const d = points.map(([epoch, v], i) => `${i ? "L" : "M"}${X(epoch).toFixed(1)} ${Y(v).toFixed(1)}`).join("");
    return `<path d="${d}" style="stroke:${colour}" ${dashed ? 'stroke-dasharray="4 3"' : ""}/>`;
  });
  const chance =
    level === null
      ? ""
      : `<line class="chance" x1="${PAD.left}" x2="${wide - PAD.right}" y1="${Y(level)}" y2="${Y(level)}"/>`;
  const now = series.map(({ name, colour, points }) => {
    const last = points.findLast(([epoch]) => epoch <= at);
    return `<span><i style="background:${colour}"></i>${name} <b>${last ? (unit === "%" ? `${(100 * last[1]).toFixed(1)} %` : last[1].toFixed(3)) : "–"}</b></span>`;
  });
  return `<figure><figcaption>${title}</figcaption><svg viewBox="0 0 ${wide} ${tall}" role="img" aria-label="${title} over epochs">${grid.join("")}${chance}${lines.join("")}<line class="now" x1="${X(at)}" x2="${X(at)}" y1="${PAD.top}" y2="${tall - PAD.bottom}"/><text x="${PAD.left}" y="${tall - 3}">1</text><text x="${wide - PAD.right}" y="${tall - 3}" text-anchor="end">${total}</text></svg><p class="now-values">${now.join("")}</p></figure>`;
}

/** The charts of a run. classes: for the chance line; wide: of a chart, in CSS pixels; bare: only those with values. */
export function charts(epochs, total, at, classes, wide = W, bare = false) {
  const of = (read) => epochs.map((one) => [one.epoch, read(one)]).filter(([, v]) => Number.isFinite(v));
  const measure = (name) => of((one) => one.measures[name]);
  const tall = bare ? 2 * H : H;
  const [blue, orange, green, grey] = ["#2f7fd1", "#d55e00", "#009e73", "#8c8c8c"];
  const accuracies = (title, series) =>
    chart({ title, series, total, at, wide, tall, top: 1, unit: "%", level: 1 / classes });
  const all = [
    chart({
      title: "Loss",
      total,
      at,
      wide,
      tall,
      series: [
        { name: "total", colour: blue, points: of((one) => one.loss) },
        { name: "cross-entropy", colour: orange, points: of((one) => one.cross_entropy) },
      ],
    }),
    accuracies("Accuracy", [
      { name: "unseen domains", colour: blue, points: measure("accuracy/unseen") },
      { name: "source test", colour: grey, points: measure("accuracy/source_test"), dashed: true },
    ]),
    accuracies("Unseen domains, one image", [
      { name: "photo only", colour: "#56b4e9", points: measure("accuracy:vis/unseen") },
      { name: "touch only", colour: "#e69f00", points: measure("accuracy:tac/unseen") },
    ]),
    chart({
      title: "Gaps of F̂",
      total,
      at,
      wide,
      tall,
      series: [
        { name: "modality", colour: orange, points: measure("modality_gap/f_hat") },
        { name: "domain", colour: green, points: measure("domain_gap/f_hat") },
      ],
    }),
    chart({
      title: "Cosine margin of F̂",
      total,
      at,
      wide,
      tall,
      series: [{ name: "margin", colour: green, points: measure("margin/f_hat") }],
    }),
    chart({
      title: "p",
      total,
      at,
      wide,
      tall,
      top: 1,
      series: [{ name: "p", colour: "#b91c1c", points: of((one) => one.order) }],
    }),
  ];
  return (bare ? [all[0], all.at(-1)] : all).join("");
}
