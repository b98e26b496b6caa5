/** The parts of Explore, connected to one scene and to the address. */

import { refused } from "../shared/api.js";
import { card } from "../shared/card.js";
import { pairNames, unseen } from "../shared/facts.js";
import { showFilters } from "../shared/filters.js";
import { orderText } from "../shared/frames.js";
import { asText, values } from "../shared/measures.js";
import { orderBar } from "../shared/order.js";
import { explained, featuresOf, projects, stageNamed } from "../shared/stages.js";
import { change, state } from "../shared/store.js";
import { Acts } from "./acts.js";
import { Balance } from "./balance.js";
import { coach } from "./coach.js";
import { Curves } from "./curves.js";
import { Finder } from "./finder.js";
import { Maps, METHODS } from "./maps.js";
import { Modes, modeWords } from "./modes.js";
import { peek } from "./peek.js";
import { Saving } from "./saving.js";
import { Scene } from "./scene.js";
import { showSelection } from "./selection.js";
import { showSets } from "./sets.js";
import { Staircase } from "./staircase.js";
import { Strangers, score, story } from "./strangers.js";
import { Toy } from "./toy.js";
import { PARTS, wire } from "./wiring.js";

const ANSWERS = ["correctness", "confidence"]; // colourings that change with p

export class Page {
  constructor($, frames, sprite, choices, say) {
    this.$ = $;
    this.lassoMode = false;
    const scene = new Scene(frames, sprite);
    this.scene = scene;
    if (state.p === null)
      state.p = frames.orders[frames.stop(Number.isFinite(frames.learned) ? frames.learned : 0.5)];
    if (state.pin !== null && !(state.pin < frames.pairs)) state.pin = null;
    this.acts = new Acts(this);
    this.maps = new Maps($, scene, this.acts.pointing());
    this.peek = peek($(".peek"), $(".maps"), scene);
    this.bar = orderBar($(".order-bar"), frames);
    const toOrder = (p) => change({ p: scene.frames.orders[scene.frames.stop(p)] });
    this.curves = new Curves($(".curves"), toOrder);
    this.stairs = new Staircase(
      $(".staircase"),
      () => state.stage,
      (stage) => change({ stage }),
    );
    this.balance = new Balance($(".balance"), () => state.gap);
    this.strangers = new Strangers($(".strangers"), scene, (cell) => this.acts.onlyCell(cell));
    this.toy = new Toy($(".toy"));
    this.finder = new Finder($(".finder"), scene);
    this.saving = new Saving($, scene, this.maps);
    this.modes = new Modes($, scene, choices.modes, { onFrames: (shown) => this.replace(shown), say });
    this.sample = frames.label.findIndex(
      (label, pair) => label === frames.prediction[frames.stop(state.p) * frames.pairs + pair],
    );
    showSets($(".sets"), choices.sets);
    wire(this);
  }

  /** Show the first mode, then the facts about the head. */
  async open(mode) {
    await this.modes.choose(mode);
    if (this.scene.frames === this.scene.own && mode !== "moved") this.replace(this.scene.own);
    coach(this.$(".order-bar"));
    pairNames().then(
      (pairs) => this.learn({ pairs }),
      () => {},
    );
    unseen().then(
      (found) => this.learn({ unseen: found }),
      (error) =>
        refused(error, (sentence) => {
          this.$(".strangers .hint").textContent = sentence;
        }),
    );
  }

  learn(facts) {
    Object.assign(this.scene.facts, facts);
    if (facts.unseen) {
      this.$(".score").innerHTML = score(facts.unseen, orderText(+facts.unseen.order.toFixed(3)));
      this.strangers.show();
    }
    this.finder.show();
    if (state.find || state.alike || state.range) this.refilter();
    if (facts.unseen && state.cell) this.strangers.follow();
  }

  /** Finer frames of the head itself have been computed. */
  finer(own) {
    this.scene.own = own;
    this.replace(this.modes.replace(own));
  }

  /** Show other frames of the same pairs. */
  replace(frames) {
    const { scene } = this;
    scene.frames = frames;
    scene.stop = frames.stop(state.p);
    this.bar.replace(frames);
    this.bar.learned(scene.own.learned);
    this.curves.replace(frames);
    this.stairs.replace(frames);
    this.balance.replace(frames);
    this.$(".story").innerHTML = story(scene.own);
    this.$(".mode-words").innerHTML = modeWords(frames);
    this.$(".explore").dataset.kind = frames.kind;
    this.showColours();
    this.showStage();
    this.showMeans();
    this.showPart();
  }

  // ---- what is shown ----------------------------------------------------------------------

  showOrder() {
    const { scene } = this;
    scene.stop = scene.frames.stop(state.p);
    this.bar.show(scene.stop);
    this.curves.mark(scene.stop);
    this.stairs.show(scene.stop);
    this.balance.show(scene.stop);
    if (state.part === "toy") this.toy.show(scene.p);
    if (state.part === "strangers") this.strangers.mark();
    if (ANSWERS.includes(state.colour)) this.maps.showLayers();
    this.maps.showNow();
    this.showCard();
    clearTimeout(this.announcing);
    this.announcing = setTimeout(() => this.announce(), 400);
  }

  showStage() {
    const { frames } = this.scene;
    if (state.stage === "projection" && !projects(frames)) return change({ stage: "frft" });
    this.stairs.choose();
    const stage = stageNamed(state.stage);
    this.$(".explain").innerHTML = `<b>${stage.name}.</b> ${explained(stage, frames)}`;
    const kinds = frames.kinds(state.stage);
    this.$(".map-kind").innerHTML = kinds
      .map((k) => `<option value="${k}">${METHODS[k] ?? k}</option>`)
      .join("");
    if (!kinds.includes(state.map) && kinds.length) change({ map: kinds[0] });
    this.$(".map-kind").value = state.map;
    this.scene.near = [];
    this.maps.showBefore();
    this.showCurves();
    return this.showOrder();
  }

  showCurves() {
    this.curves.show(state.stage, this.scene.loneDomain());
    this.curves.mark(this.scene.stop);
  }

  showColours() {
    this.$(".colouring").value = state.colour;
    showFilters(this.$(".filters"), this.scene.frames, (name) => {
      this.scene.highlight = name;
      this.maps.showLayers();
    });
    this.refilter();
  }

  /** Apply the filters everywhere: maps, titles, curves, selection, what is saved. */
  refilter() {
    if (this.scene.refilter()) this.showSelected();
    this.maps.showLayers();
    this.maps.showBefore();
    if (this.maps.now.frame) this.maps.showNow();
    this.showCurves();
    if (this.scene.facts.unseen) this.finder.count();
    this.saving.label();
  }

  showPart() {
    for (const part of PARTS) {
      this.$(`.${part}`).hidden = part !== state.part;
      const tab = this.$(`[data-part="${part}"]`);
      tab.setAttribute("aria-selected", part === state.part);
      tab.tabIndex = part === state.part ? 0 : -1;
    }
    if (state.part === "toy") this.toy.open().then(() => this.toy.show(this.scene.p));
    if (state.part === "strangers") this.strangers.mark();
  }

  showCard() {
    const { scene } = this;
    const pair = scene.hovered >= 0 ? scene.hovered % scene.frames.pairs : (state.pin ?? -1);
    this.$(".card").innerHTML = card(
      scene.frames,
      scene.sprite,
      pair,
      scene.stop,
      pair >= 0 && pair === state.pin,
      this.sample,
      scene.facts.pairs,
    );
  }

  showMeans() {
    this.$(".tool.means").setAttribute("aria-pressed", state.means === "1");
    this.maps.paintMarks();
  }

  showSelected() {
    const { frames, sprite, selected, stop } = this.scene;
    const onClear = () => this.acts.select([]);
    showSelection(this.$(".selection"), {
      frames,
      sprite,
      points: [...selected],
      stop,
      pairs: this.scene.facts.pairs,
      onPick: (point) => this.acts.pick(point),
      onClear,
      onSave: () => this.saving.save("csv"),
    });
    this.saving.label();
  }

  announce() {
    const { frames, stop } = this.scene;
    const parts = [`p ${orderText(frames.orders[stop])}`];
    const gap = values(frames, "modality_gap", featuresOf(state.stage))?.[stop];
    if (Number.isFinite(gap)) parts.push(`modality gap ${asText("modality_gap", gap)}`);
    const right = values(frames, "accuracy", "f_hat")?.[stop];
    if (Number.isFinite(right)) parts.push(`accuracy on unseen domains ${asText("accuracy", right)}`);
    this.$(".said").textContent = parts.join(", ");
  }
}
