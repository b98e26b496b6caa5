/** The mechanism on a toy: the transform keeps distances; after the ReLU they depend on p. */

import { attempt } from "../shared/api.js";
import { Scale } from "../shared/chart.js";
import { toyFacts } from "../shared/facts.js";
import { nearest, orderText } from "../shared/frames.js";
import { TAC_COLOUR, VIS_COLOUR } from "../shared/palette.js";
import { each } from "../shared/text.js";
import { View } from "../shared/view.js";

const W = 300;
const HALF = W / 2 - 6; // of two pictures side by side
const SIGNAL = 66;
const PLANE = 146;
const REACH = 2.1; // of the plane, from its middle
const COLOURS = { vis: VIS_COLOUR, tac: TAC_COLOUR };
const ACTS = { turned: (v) => v, clipped: (v) => Math.max(0, v) };
const CURVE = new Scale({ wide: W, high: 92, pad: { left: 30, right: 8, top: 8, bottom: 18 }, ys: [0, 2.2] });

export class Toy extends View {
  /** Fetch the toy and draw; later calls only draw. */
  async open() {
    if (this.facts) return;
    await attempt(async () => {
      this.facts = await toyFacts();
      this.box.append(this.$("template").content);
      this.set(".apart", distances(this.facts));
    }, this.box);
  }

  /** Draw the stop nearest to p. */
  show(p) {
    if (!this.facts) return;
    const { orders, signals, clouds, distances: apart } = this.facts;
    const i = nearest(orders, p);
    for (const [act, clip] of Object.entries(ACTS)) {
      for (const [name, { re, im }] of Object.entries(signals))
        this.set(`.${act}.${name}`, waves(re[i], im[i], COLOURS[name], clip));
      this.set(`.${act}-plane`, plane(clouds, i, clip));
      this.set(`.d-${act}`, apart.signals[act][i].toFixed(2));
      this.set(`.g-${act}`, apart.clouds[act][i].toFixed(2));
    }
    this.set(".at-p", `p = ${orderText(orders[i])}`);
    CURVE.mark(this.box, orders[i]);
  }

  set(selector, inner) {
    this.$(selector).innerHTML = inner;
  }
}

/** Real and imaginary part of one signal; `act` is the last operation. */
function waves(re, im, colour, act) {
  const line = (all) =>
    each(
      all,
      (v, k) =>
        `${k ? "L" : "M"}${((k / (all.length - 1)) * HALF).toFixed(1)} ${(SIGNAL / 2 - act(v) * 38).toFixed(1)}`,
    );
  return `<path class="zero" d="M0 ${SIGNAL / 2}H${HALF}"/><path d="${line(im)}" style="stroke:${colour}" class="im"/><path d="${line(re)}" style="stroke:${colour}"/>`;
}

/** Two clouds in the plane, their means, and the line between the means. */
function plane(clouds, i, act) {
  const at = ([x, y]) => [HALF / 2 + (act(x) / REACH) * (PLANE / 2), PLANE / 2 - (act(y) / REACH) * (PLANE / 2)];
  const middle = (points) => points.reduce(([a, b], [x, y]) => [a + x / points.length, b + y / points.length], [0, 0]);
  const drawn = { vis: clouds.vis[i].map(at), tac: clouds.tac[i].map(at) };
  const dots = {
    vis: ([x, y]) => `M${x - 2} ${y}a2 2 0 1 0 4 0a2 2 0 1 0 -4 0`,
    tac: ([x, y]) => `M${x} ${y - 2.6}l2.6 4.6h-5.2z`,
  };
  const [a, b] = [middle(drawn.vis), middle(drawn.tac)];
  return `<path class="zero" d="M0 ${PLANE / 2}H${HALF}M${HALF / 2} 0V${PLANE}"/>${each(["vis", "tac"], (name) => `<path d="${each(drawn[name], dots[name])}" style="fill:${COLOURS[name]}"/>`)}<path class="gap-line" d="M${a}L${b}"/>`;
}

/** Both distances against p, before and after the ReLU. */
function distances({ orders, distances: { signals, clouds } }) {
  const line = (all, kind) => `<path class="${kind}" d="${CURVE.line(orders.map((p, i) => [p, all[i]]))}"/>`;
  return `${CURVE.grid(CURVE.ys, (v) => v)}${CURVE.ticks(
    [
      [0, 0],
      [0.5, "p"],
      [1, 1],
    ],
    3,
  )}${line(signals.turned, "flat")}${line(signals.clipped, "moves")}${line(clouds.turned, "flat clouds")}${line(clouds.clipped, "moves clouds")}${CURVE.now()}`;
}
