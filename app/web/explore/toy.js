/** The mechanism on a toy: the transform keeps distances; after the ReLU they depend on p. */

import { attempt } from "../shared/api.js";
import { Scale } from "../shared/chart.js";
import { toyFacts } from "../shared/facts.js";
import { nearest, orderText } from "../shared/frames.js";
import { mean } from "../shared/numbers.js";
import { TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { OUTLINES } from "../shared/points.js";
import { $, draw, html } from "./root.js";

const W = 300;
const HALF = W / 2 - 6; // of two pictures side by side
const SIGNAL = 66;
const PLANE = 146;
/** The two operations: what each does, in words after "signal" and "clouds", and to a number. */
const ACTS = /** @type {const} */ ([
  {
    act: "turned",
    title: "1 · The transform rotates",
    signal: ", transformed",
    cloud: ", rotated",
    when: "at every p",
  },
  {
    act: "clipped",
    title: "2 · The ReLU clips",
    signal: " after the ReLU",
    cloud: " after the ReLU",
    when: "changes with p",
  },
]);
/** @typedef {"turned" | "clipped"} Act */
/** @type {(act: Act, v: number) => number} */
const after = (act, v) => (act === "turned" ? v : Math.max(0, v));
const IMAGES = /** @type {const} */ ([
  { name: "vis", what: "photo", colour: VIS_COLOUR, shape: "circle" },
  { name: "tac", what: "touch", colour: TAC_COLOUR, shape: "triangle" },
]);
const CURVE = new Scale({ wide: W, high: 92, pad: { left: 30, right: 8, top: 8, bottom: 18 }, ys: [0, 2.2] });
const NONE = { left: 0, right: 0, top: 0, bottom: 0 };
const WAVES = new Scale({ wide: HALF, high: SIGNAL, pad: NONE, ys: [-0.87, 0.87] });
const REACH = 2.1; // of the plane upwards, from its middle; as far to the side for its width
const ASIDE = (REACH * HALF) / PLANE;
const PLANES = new Scale({ wide: HALF, high: PLANE, pad: NONE, xs: [-ASIDE, ASIDE], ys: [-REACH, REACH] });

/** Draw the stop nearest to p; the first call fetches the toy. @param {number} p */
export const show = (p) => attempt(async () => draw($(".toy"), toyHtml(await toyFacts(), p)), $(".toy"));

/** Return the signals, the clouds and their distances at the stop nearest to p. @param {Toy} toy @param {number} p */
function toyHtml(toy, p) {
  const { orders, signals, clouds, distances } = toy;
  const i = nearest(orders, p);
  const far = (/** @type {string} */ what, /** @type {"signals" | "clouds"} */ of) =>
    ACTS.map(
      ({ act, when }) =>
        html`<p>${what} <output class="${what[0]}-${act}">${distances[of][act][i].toFixed(2)}</output>, ${when}</p>`,
    );
  const waves = IMAGES.map(({ name, what, colour }) =>
    ACTS.map(({ act, signal }) => {
      const { re, im } = signals[name];
      return WAVES.svg(`the ${what}’s signal${signal}`, wave(re[i], im[i], colour, act));
    }),
  );
  const planes = ACTS.map(
    ({ act, cloud }) => html`<div class="plane">${PLANES.svg(`two clouds${cloud}`, plane(clouds, i, act))}</div>`,
  );
  return html`<p>The two signals belong to <b class="vis">a photo</b> and <b class="tac">a touch</b>. <b>Drag
    p</b> above; now <output>p = ${orderText(orders[i])}</output>.</p>
<div class="toy-grid">${ACTS.map(({ title }) => html`<h4>${title}</h4>`)}${waves}${far("distance", "signals")}${planes}
  ${far("gap", "clouds")}</div>
<h4>Distance against p</h4>
${apart(toy, orders[i])}
<p class="hint">Solid line: real part. Dotted line: imaginary part. Near p = 0.35, each signal becomes one spike. The
  clouds show one coefficient of 40 photos ● and 40 touches ▲. The transform rotates them by p quarter turns.</p>`;
}

/** Return real and imaginary part of one signal after an operation.
 * @param {number[]} re @param {number[]} im @param {string} colour @param {Act} act */
function wave(re, im, colour, act) {
  const line = (/** @type {number[]} */ all) => WAVES.line(all.map((v, k) => [k / (all.length - 1), after(act, v)]));
  return html`<path class="zero" d="M0 ${SIGNAL / 2}H${HALF}"/><path d="${line(im)}" style="stroke:${colour}"
    class="im"/><path d="${line(re)}" style="stroke:${colour}"/>`;
}

/** Return two clouds in the plane, and the line between their means.
 * @param {Toy["clouds"]} clouds @param {number} i @param {Act} act */
function plane(clouds, i, act) {
  const drawn = IMAGES.map(({ name, colour, shape }) => {
    const places = clouds[name][i].map(([x, y]) => [PLANES.x(after(act, x)), PLANES.y(after(act, y))]);
    const middle = [0, 1].map((axis) => mean(places.map((place) => place[axis])));
    const dots = places.map(([x, y]) => OUTLINES[shape](x, y, 2)).join("");
    return { middle, path: html`<path d="${dots}" style="fill:${colour}"/>` };
  });
  return html`<path class="zero" d="M0 ${PLANE / 2}H${HALF}M${HALF / 2} 0V${PLANE}"/>${drawn.map(({ path }) => path)}
    <path class="gap-line" d="${drawn.map(({ middle }, k) => `${k ? "L" : "M"}${middle}`).join("")}"/>`;
}

/** Return both distances against p, before and after the ReLU. @param {Toy} toy @param {number} p */
function apart({ orders, distances }, p) {
  const ends = [
    [0, 0],
    [0.5, "p"],
    [1, 1],
  ];
  const lines = /** @type {("signals" | "clouds")[]} */ (["signals", "clouds"]).flatMap((of) =>
    ACTS.map(({ act }) => {
      const kind = `${act === "turned" ? "flat" : "moves"}${of === "clouds" ? " clouds" : ""}`;
      return html`<path class="${kind}" d="${CURVE.line(orders.map((p, i) => [p, distances[of][act][i]]))}"/>`;
    }),
  );
  return CURVE.svg(
    "Distances against p: flat after the transform, not flat after the ReLU",
    CURVE.grid(CURVE.ys, (v) => v),
    CURVE.ticks(ends, 3),
    lines,
    CURVE.now(p),
  );
}

/* ---- one chirp, turned by the slider: long at most orders, one spike at its own ---- */

const WAVE = new Scale({ wide: 300, high: 74, pad: { left: 2, right: 2, top: 6, bottom: 4 } });

/** Draw the stop nearest to p; the first call fetches the signal. @param {number} p */
export const showWave = (p) =>
  attempt(async () => {
    const { orders, signals } = await toyFacts();
    const { re, im } = signals.vis;
    const stop = nearest(orders, p);
    const all = re[stop].map((v, k) => Math.hypot(v, im[stop][k]));
    const line = WAVE.line(all.map((v, k) => [k / (all.length - 1), v]));
    draw(
      $(".wave"),
      html`<svg class="chart" viewBox="0 0 300 74" preserveAspectRatio="none" role="img"
        aria-label="One chirp, transformed with order p: its largest sample is ${Math.max(...all).toFixed(2)} of 1">
        <path d="${line}"/></svg>`,
    );
  }, $(".wave"));
