/** A second map beside the first: the same pairs at a step, a p and by a method of its own; both are linked. */

import { Refusal, refused } from "../shared/api.js";
import { Cloud } from "../shared/cloud.js";
import { orderText } from "../shared/frames.js";
import { framesBy, headLabel, heads, isMethod, methodsFor } from "../shared/headsets.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames, lassoLine, pairLine } from "../shared/marks.js";
import { means } from "../shared/means.js";
import { asText, values } from "../shared/measures.js";
import { isDark } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { stageNamed, stepsOf } from "../shared/stages.js";
import { change, state } from "../shared/store.js";
import { define } from "../shared/terms.js";
import { escaped, options } from "../shared/text.js";
import { making, tell, View } from "../shared/view.js";
import { counted, sentence } from "./changes.js";
import { whence } from "./chapters.js";

const named = (name, words, value) =>
  Number.isFinite(value) ? `<span class="gap">${words} <b>${asText(name, value, 2)}</b></span>` : "";

/** The two gaps of frames at a stop, as HTML. */
export const gaps = (frames, stage, stop) =>
  [
    ["modality_gap", "modality gap"],
    ["domain_gap", "domain gap"],
  ]
    .map(([name, words]) => named(name, words, values(frames, name, stage)?.[stop]))
    .join(" ");

/** The accuracy of frames at a stop, and whose it is; only where the head predicts. */
export const right = (frames, stage, stop, unseen) =>
  stage === "f_hat"
    ? named("accuracy", "right, unseen", values(frames, "accuracy", stage)?.[stop]) + whence(frames, stop, unseen)
    : "";

const MAP = '<div class="map" role="application" aria-label="Second map of the same features"></div>';

export class Beside extends View {
  /** `first`: the map beside this one; `on` as in pointer.js. */
  constructor($, scene, first, on) {
    super($(".beside"));
    this.scene = scene;
    this.first = first;
    this.told = $(".changed");
    this.title = $(".now .pane");
    this.maps = $(".maps");
    /** @type {any} */
    this.cloud = null; // made when the map is first opened
    this.on = on;
    /** @type {any} */
    this.other = null; // {name, frames} of another head or method, once loaded
    this.$(".by").onchange = ({ target }) => change({ head2: target.value });
    this.$(".step").onchange = ({ target }) => change({ stage2: target.value });
    this.$(".its-p").oninput = ({ target }) => change({ p2: this.frames.orders[this.frames.stop(+target.value)] });
  }

  get open() {
    return state.beside === "1" && state.chapter === "analyse" && !this.scene.frames.headless;
  }

  get frames() {
    return this.other?.name === state.head2 ? this.other.frames : this.scene.frames;
  }

  /** Its own p, or that of the first map until it has one. */
  get stop() {
    return this.frames.stop(state.p2 ?? this.scene.p);
  }

  /** The frames belong to what is chosen. */
  get ready() {
    return !state.head2 || this.other?.name === state.head2;
  }

  make() {
    const { scene } = this;
    this.box.insertAdjacentHTML("beforeend", MAP);
    const cloud = (this.cloud = new Cloud(this.$(".map"), 2 * scene.own.pairs));
    const drawing = listen(cloud, this.on);
    const line = (x, cloud, pair, colour) => pair !== null && pair >= 0 && pairLine(x, cloud, pair, colour);
    cloud.painters = [
      axes(() => axisNames(this.first.kind(this.stage))),
      means(() => this.frames, scene.shown),
      (x, c) => line(x, c, state.pin, "#dc2626"),
      (x, c) =>
        line(x, c, scene.hovered < 0 ? -1 : scene.hovered % scene.frames.pairs, isDark() ? "#38bdf8" : "#1e293b"),
      (x) => lassoLine(x, drawing.polygon),
    ];
    cloud.onView = (view) => this.first.now.setView(view, true);
    this.first.now.onView = (view) => cloud.setView(view, true);
  }

  /** What predicts can be chosen from: the heads, and a method fitted on the source. */
  async offer() {
    const { own } = this.scene;
    const [first, ...more] = await heads().catch(() => [{ folder: "the head", problem: true }]);
    const known = more.filter(({ problem }) => !problem).map((one) => [one.name, headLabel(one)]);
    const all = [["", headLabel(first)], ...known, ...methodsFor(own)];
    this.$(".by").innerHTML = options(all, state.head2);
  }

  get stage() {
    return stageNamed(state.stage2).key;
  }

  /** Open or close it, with what is chosen. */
  async follow() {
    this.maps.classList.toggle("two", this.open);
    this.box.hidden = this.title.hidden = !this.open;
    this.told.hidden = true;
    if (!this.open) return;
    if (!this.cloud) {
      this.make();
      await this.offer();
    }
    const { own, frames } = this.scene;
    if (this.cloud.count !== 2 * own.pairs) this.cloud.hold(2 * own.pairs);
    this.$(".step").innerHTML = options(
      stepsOf(frames).map(({ key, name }) => [key, name]),
      this.stage,
    );
    this.show();
    await this.load();
  }

  async load() {
    const wait = this.$(".side-wait");
    const name = state.head2;
    if (this.ready) return;
    try {
      const frames = await framesBy(
        name,
        this.scene.own,
        (step) => tell(wait, making(step)),
        () => this.load(),
      );
      if (frames.pairs !== this.scene.own.pairs) throw new Refusal("This head’s map belongs to another set.");
      if (state.head2 !== name) return;
      this.other = { name, frames };
      tell(wait, "");
      this.show();
    } catch (error) {
      refused(error, (words) => state.head2 === name && tell(wait, words));
    }
  }

  /** Draw both titles, the map, and what changes from one to the other. */
  show() {
    if (!this.open || !this.cloud) return;
    const { frames, stop, stage, scene } = this;
    this.$(".by").value = state.head2;
    const kinds = frames.kinds(stage);
    const kind = kinds.includes(state.map) ? state.map : kinds[0];
    const slider = this.$(".its-p");
    [slider.min, slider.max] = [frames.orders[0], frames.orders.at(-1)];
    slider.value = frames.orders[stop];
    slider.disabled = isMethod(state.head2);
    this.$("output").textContent = slider.disabled ? "–" : orderText(frames.orders[stop]);
    this.cloud.layers = layersOf(frames, stop, scene.shown, scene.lit);
    this.cloud.show(frames.positions(kind, stage, stop));
    this.cloud.box.dataset.order = frames.orders[stop];
    const same = frames === scene.frames && stop === scene.stop; // the accuracy stands beside the first map
    this.$(".pane-title").innerHTML = this.ready
      ? `${gaps(frames, stage, stop)} ${same ? "" : right(frames, stage, stop, scene.facts.unseen)}`
      : "";
    this.title.innerHTML = `<b>${escaped(stageNamed(state.stage).name)}</b> p = ${orderText(scene.frames.orders[scene.stop])} ${gaps(scene.frames, state.stage, scene.stop)}`;
    for (const told of [this.$(".pane-title"), this.title]) define(told);
    this.tell();
  }

  /** The predictions that differ, of the pairs that count. */
  tell() {
    const { scene, frames, stop } = this;
    const counts = scene.facts.unseen?.pairs.counts;
    this.told.hidden = !counts || !this.ready || (frames === scene.frames && stop === scene.stop);
    if (this.told.hidden) return;
    const said = (of, at) => (pair) => of.classes[of.prediction[at * of.pairs + pair]];
    const truth = (pair) => scene.frames.classes[scene.frames.label[pair]];
    const pairs = Array.from(counts.keys()).filter((pair) => counts[pair]);
    this.told.innerHTML = sentence(counted(pairs, said(scene.frames, scene.stop), said(frames, stop), truth));
  }

  paintMarks() {
    if (this.open) this.cloud?.paintMarks();
  }
}
