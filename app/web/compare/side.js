/** One side of Compare: head or method, stage, p and domain; its map and its measures. */

import { Refusal, refused } from "../shared/api.js";
import { Cloud } from "../shared/cloud.js";
import { orderText } from "../shared/frames.js";
import { framesBy, headLabel, isMethod, methodsFor } from "../shared/headsets.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames, lassoLine, pairLine } from "../shared/marks.js";
import { means } from "../shared/means.js";
import { asText, MEASURES, values } from "../shared/measures.js";
import { isDark } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { STAGES } from "../shared/stages.js";
import { change, state } from "../shared/store.js";
import { each, escaped, options } from "../shared/text.js";
import { making, tell, View } from "../shared/view.js";
import { difference } from "./changes.js";

const OF_ONE_DOMAIN = ["modality_gap", "accuracy"]; // available for a single domain

/** The state's names for the settings of each side. */
export const SIDES = [
  { p: "p2", stage: "stage2", head: "head2", only: "only2", name: "left" }, // its own
  { p: "p", stage: "stage", head: "head", only: "only", name: "right" }, // p and stage of Explore
];

export function sideHtml({ name }, frames, known) {
  const heads = [
    ["", known[0] ? headLabel(known[0]) : "the head"],
    ...known.slice(1).map((one) => [one.name, headLabel(one)]),
    ...methodsFor(frames),
  ];
  return `<article class="panel side-${name}"><div class="side-bar"><label>Predicted by <select class="head">${options(heads)}</select></label>
    <label>Domain <select class="only">${options([["", "all"], ...frames.domains.map((d) => [d, d])])}</select></label></div>
    <div class="side-bar"><label>Stage <select class="stage">${options(STAGES.map((s) => [s.key, s.name]))}</select></label>
    <label class="grow"><i>p</i> <input type="range" class="order" min="${frames.orders[0]}" max="${frames.orders.at(-1)}" step="0.001" aria-label="p of the ${name} map"></label><output class="order-value"></output></div><p class="side-wait hint" role="status" hidden></p>
    <div class="map" role="application" aria-label="${name} map"></div><table class="numbers"><tbody></tbody></table></article>`;
}

export class Side extends View {
  /** board: the tab of both sides. */
  constructor(keys, box, frames, board) {
    super(box);
    this.keys = keys;
    this.frames = frames; // frames of the predictions and maps shown
    this.board = board;
    this.loaded = null; // the head of these frames
    this.cloud = new Cloud(this.$(".map"), 2 * frames.pairs);
    this.drawing = listen(this.cloud, {
      wanted: (point) => this.shows(point),
      hover: (point) => board.hover(point),
      pick: (point) => board.pick(point),
      lasso: (points) => board.select(points),
      lassoMode: () => board.lassoMode,
      current: () => board.hovered,
      next: (by) => board.step(by),
    });
    this.cloud.painters = this.painters();
    this.wire();
  }

  get chosen() {
    const { keys } = this;
    return { p: state[keys.p], stage: state[keys.stage], head: state[keys.head], only: state[keys.only] };
  }

  get stop() {
    return this.frames.stop(this.chosen.p);
  }

  get kind() {
    const kinds = this.frames.kinds(this.chosen.stage);
    return kinds.includes(state.map) ? state.map : kinds[0];
  }

  /** The head or method of this side, in words. */
  get who() {
    const { head } = this.chosen;
    if (isMethod(head)) return "nearest class mean";
    return `${head || "the head"} at p = ${this.order}`;
  }

  /** p in figures; the learned one is another one than its nearest hundredth, and is marked. */
  get order() {
    const { orders, learned } = this.frames;
    const p = orders[this.stop];
    return `${orderText(p)}${Math.abs(p - learned) < 1e-6 ? " (learned)" : ""}`;
  }

  /** True if the frames shown belong to the chosen head. */
  get ready() {
    return this.loaded === this.chosen.head;
  }

  said = (pair) => this.frames.classes[this.frames.prediction[this.stop * this.frames.pairs + pair]];

  inDomain(pair) {
    const { only } = this.chosen;
    return !only || this.frames.domains[this.frames.domain[pair]] === only;
  }

  shows(point) {
    return this.board.inPlay(point) && this.inDomain(point % this.frames.pairs);
  }

  painters() {
    const { board, frames } = this;
    const line = (context, cloud, pair, colour) =>
      pair !== null && pair >= 0 && this.inDomain(pair) && pairLine(context, cloud, pair, colour);
    return [
      axes(() => axisNames(this.kind)),
      means(
        () => frames,
        (point) => this.shows(point),
        () => true,
      ),
      (x, c) => line(x, c, state.pin, "#dc2626"),
      (x, c) => line(x, c, board.hoveredPair, isDark() ? "#38bdf8" : "#1e293b"),
      (x) => lassoLine(x, this.drawing.polygon),
    ];
  }

  wire() {
    const { keys } = this;
    this.cloud.onView = (view) => this.board.follow(this, view);
    this.$(".order").oninput = (event) => {
      const { orders } = this.frames;
      change({ [keys.p]: orders[this.frames.stop(+event.target.value)] });
    };
    for (const name of ["stage", "head", "only"]) {
      this.$(`.${name}`).onchange = (event) => change({ [keys[name]]: event.target.value });
    }
  }

  /** Fetch the frames of this side; the current ones stay until they arrive. */
  async load(own, onFiner) {
    const wait = this.$(".side-wait");
    const name = this.chosen.head;
    const telling = (step) => tell(wait, making(step));
    if (name) telling(null);
    this.failed = false;
    try {
      const found = await framesBy(name, own, telling, onFiner);
      if (this.chosen.head !== name) return;
      if (found.pairs !== own.pairs) throw new Refusal("This head’s map belongs to another set.");
      this.frames = found;
      this.loaded = name;
      tell(wait, "");
      this.$(".order").disabled = isMethod(name);
    } catch (error) {
      if (this.chosen.head !== name) return; // a late failure of a head that is no longer chosen
      this.failed = true;
      refused(error, (sentence) => tell(wait, sentence));
    }
  }

  show() {
    const { chosen, stop, frames } = this;
    for (const name of ["stage", "head", "only"]) this.$(`.${name}`).value = chosen[name];
    this.$(".order").value = frames.orders[stop];
    this.$(".order-value").textContent = isMethod(chosen.head) ? "–" : this.order;
    this.cloud.layers = layersOf(
      frames,
      stop,
      (point) => this.shows(point),
      (point) => this.board.lit(point % frames.pairs),
    );
    this.cloud.show(frames.positions(this.kind, chosen.stage, stop));
    this.cloud.box.dataset.order = frames.orders[stop];
    this.$("tbody").innerHTML = `<tr>${each(MEASURES, (measure) => this.cell(measure))}</tr>`;
  }

  /** The value of a measure here; accuracy only at F̂, where the head predicts. */
  value({ name }) {
    if (!this.ready) return NaN; // the frames shown belong to another head
    const { stage, only, head } = this.chosen;
    const one = OF_ONE_DOMAIN.includes(name);
    if (only && !one) return NaN;
    if (name === "accuracy" && stage !== "f_hat" && !isMethod(head)) return NaN;
    return values(this.frames, name, stage, one ? only : "")?.[this.stop] ?? NaN;
  }

  cell(measure) {
    const own = this.value(measure);
    const other = this.board.sides[0];
    const off = this === other || !other ? "" : difference(own, other.value(measure), measure.name === "accuracy");
    return `<td title="${escaped(measure.help)}"><span>${measure.title}${measure.name === "accuracy" && !this.chosen.only ? ", unseen" : ""}</span><b>${asText(measure.name, own)}</b> ${off && `<small>${off}</small>`}</td>`;
  }
}
