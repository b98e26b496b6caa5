/** The mechanism on a toy: the transform keeps distances; after the ReLU they depend on p. */

import { refused } from "../shared/api.js";
import { toyFacts } from "../shared/facts.js";
import { orderText } from "../shared/frames.js";
import { TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";

const W = 300;
const SIGNAL = 66;
const PLANE = 146;
const REACH = 2.1; // of the plane, from its middle
const COLOURS = { vis: VIS_COLOUR, tac: TAC_COLOUR };
const NAMES = { vis: "photo", tac: "touch" };
const CURVE = { high: 92, left: 30, bottom: 18, top: 8 };
const clipped = (v) => Math.max(0, v);

export class Toy {
  constructor(box) {
    this.box = box;
    this.p = 0.5;
  }

  /** Fetch the toy and draw; later calls only draw. */
  async open() {
    if (this.facts) return this.show(this.p);
    try {
      this.facts = await toyFacts();
    } catch (error) {
      refused(error, (sentence) => {
        this.box.innerHTML = `<p class="hint">${sentence}</p>`;
      });
      return undefined;
    }
    this.box.innerHTML = LAYOUT;
    this.curve = this.box.querySelector(".apart");
    this.curve.innerHTML = distances(this.facts);
    return this.show(this.p);
  }

  /** Draw the stop nearest to p. */
  show(p) {
    this.p = p;
    if (!this.facts) return;
    const { orders, signals, clouds, distances: apart } = this.facts;
    const i = orders.reduce((best, order, k) => (Math.abs(order - p) < Math.abs(orders[best] - p) ? k : best), 0);
    for (const name of ["vis", "tac"]) {
      const { re, im } = signals[name];
      this.set(
        `.turned.${name}`,
        waves(re[i], im[i], COLOURS[name], (v) => v),
      );
      this.set(`.clipped.${name}`, waves(re[i], im[i], COLOURS[name], clipped));
    }
    this.set(
      ".plane.turned-plane",
      plane(clouds, i, (v) => v),
    );
    this.set(".plane.clipped-plane", plane(clouds, i, clipped));
    const say = (selector, value) => {
      this.box.querySelector(selector).textContent = value.toFixed(2);
    };
    say(".d-turned", apart.signals.turned[i]);
    say(".d-clipped", apart.signals.clipped[i]);
    say(".g-turned", apart.clouds.turned[i]);
    say(".g-clipped", apart.clouds.clipped[i]);
    this.box.querySelector(".at-p").textContent = `p = ${orderText(orders[i])}`;
    const x = CURVE.left + (W - CURVE.left - 8) * orders[i];
    this.curve.querySelector(".now").setAttribute("d", `M${x} ${CURVE.top}V${CURVE.high - CURVE.bottom}`);
  }

  set(selector, inner) {
    this.box.querySelector(selector).innerHTML = inner;
  }
}

const svg = (kind, high, label) =>
  `<svg class="${kind}" viewBox="0 0 ${W / 2 - 6} ${high}" role="img" aria-label="${label}"></svg>`;
const LAYOUT = `<p>Two signals, <b class="vis">a photo’s</b> and <b class="tac">a touch’s</b>. <b>Drag p</b> above; now <output class="at-p"></output>.</p>
  <div class="toy-grid"><h4>1 · The transform turns</h4><h4>2 · The ReLU clips</h4>
  ${["vis", "tac"].map((name) => svg(`turned ${name}`, SIGNAL, `the ${NAMES[name]}’s signal, transformed`) + svg(`clipped ${name}`, SIGNAL, `the ${NAMES[name]}’s signal after the ReLU`)).join("")}
  <p>distance <output class="d-turned"></output>, at every p</p><p>distance <output class="d-clipped"></output>, changes with p</p>
  ${svg("plane turned-plane", PLANE, "two clouds, turned")}${svg("plane clipped-plane", PLANE, "two clouds after the ReLU")}
  <p>gap <output class="g-turned"></output>, at every p</p><p>gap <output class="g-clipped"></output>, changes with p</p></div>
  <h4>Distance against p</h4><svg class="apart" viewBox="0 0 ${W} ${CURVE.high}" role="img" aria-label="Distances against p: flat after the transform, not flat after the ReLU"></svg>
  <p class="hint">Solid: real part; dotted: imaginary part. Near p = 0.35 each signal becomes one spike. The clouds show one coefficient of 40 photos ● and 40 touches ▲; the transform rotates them by p quarter turns.</p>`;

/** Real and imaginary part of one signal; `act` is the last operation. */
function waves(re, im, colour, act) {
  const wide = W / 2 - 6;
  const line = (all) =>
    all
      .map(
        (v, k) =>
          `${k ? "L" : "M"}${((k / (all.length - 1)) * wide).toFixed(1)} ${(SIGNAL / 2 - act(v) * 38).toFixed(1)}`,
      )
      .join("");
  return `<path class="zero" d="M0 ${SIGNAL / 2}H${wide}"/><path d="${line(im)}" style="stroke:${colour}" class="im"/><path d="${line(re)}" style="stroke:${colour}"/>`;
}

/** Two clouds in the plane, their means, and the line between the means. */
function plane(clouds, i, act) {
  const wide = W / 2 - 6;
  const at = ([x, y]) => [wide / 2 + (act(x) / REACH) * (PLANE / 2), PLANE / 2 - (act(y) / REACH) * (PLANE / 2)];
  const middle = (points) => points.reduce(([a, b], [x, y]) => [a + x / points.length, b + y / points.length], [0, 0]);
  const drawn = { vis: clouds.vis[i].map(at), tac: clouds.tac[i].map(at) };
  const dots = {
    vis: ([x, y]) => `M${x - 2} ${y}a2 2 0 1 0 4 0a2 2 0 1 0 -4 0`,
    tac: ([x, y]) => `M${x} ${y - 2.6}l2.6 4.6h-5.2z`,
  };
  const [a, b] = [middle(drawn.vis), middle(drawn.tac)];
  return `<path class="zero" d="M0 ${PLANE / 2}H${wide}M${wide / 2} 0V${PLANE}"/>${["vis", "tac"].map((name) => `<path d="${drawn[name].map(dots[name]).join("")}" style="fill:${COLOURS[name]}"/>`).join("")}<path class="gap-line" d="M${a}L${b}"/>`;
}

/** Both distances against p, before and after the ReLU. */
function distances({ orders, distances: apart }) {
  const most = 2.2;
  const point = (v, i) =>
    `${(CURVE.left + (W - CURVE.left - 8) * orders[i]).toFixed(1)} ${(CURVE.high - CURVE.bottom - (v / most) * (CURVE.high - CURVE.bottom - CURVE.top)).toFixed(1)}`;
  const line = (all, kind) => `<path class="${kind}" d="M${all.map(point).join("L")}"/>`;
  const base = CURVE.high - CURVE.bottom;
  return `<path class="zero" d="M${CURVE.left} ${base}H${W - 8}"/><text x="${CURVE.left - 5}" y="${base + 4}" text-anchor="end">0</text><text x="${CURVE.left - 5}" y="${CURVE.top + 8}" text-anchor="end">${most}</text>
    <text x="${CURVE.left}" y="${CURVE.high - 3}">0</text><text x="${W / 2}" y="${CURVE.high - 3}" text-anchor="middle">p</text><text x="${W - 8}" y="${CURVE.high - 3}" text-anchor="end">1</text>
    ${line(apart.signals.turned, "flat")}${line(apart.signals.clipped, "moves")}${line(apart.clouds.turned, "flat clouds")}${line(apart.clouds.clipped, "moves clouds")}<path class="now"/>`;
}
