/** What Explore shows of a set: its parts, connected to one scene. */

import { card } from "../shared/card.js";
import { showFilters } from "../shared/filters.js";
import { orderText } from "../shared/frames.js";
import { asText, gapsOf, values } from "../shared/measures.js";
import { orderBar } from "../shared/order.js";
import { colouring, isLecture } from "../shared/palette.js";
import { afterwards } from "../shared/ready.js";
import { explained, featuresOf, stageNamed, stepsOf } from "../shared/stages.js";
import { change, state } from "../shared/store.js";
import { modeOf } from "../shared/tables.js";
import { define } from "../shared/terms.js";
import { fill } from "../shared/text.js";
import { press } from "../shared/view.js";
import { Acts } from "./acts.js";
import { chapterNamed, decided, featuresHtml, headOf, whence } from "./chapters.js";
import { Curves } from "./curves.js";
import { Finder } from "./finder.js";
import { showGrid } from "./grid.js";
import { Maps } from "./maps.js";
import { modeWords } from "./modes.js";
import { Nodes } from "./nodes.js";
import { panels } from "./panels.js";
import { peek } from "./pictures.js";
import { Saving } from "./saving.js";
import { Scene } from "./scene.js";
import { Staircase } from "./staircase.js";
import { Strangers } from "./strangers.js";
import { Together } from "./together.js";
import { Toy } from "./toy.js";
import { Wave } from "./wave.js";

const ANSWERS = ["Correctness", "Confidence"]; // colourings that change with p

export class Board {
  /** `data` as in library.js; `threads` is the map of the second chapter. */
  constructor($, data, threads) {
    this.$ = $;
    this.threads = threads;
    this.lassoMode = false;
    this.sample = -1; // the pair that the card shows at first
    const scene = (this.scene = new Scene(data));
    this.acts = new Acts(this);
    this.maps = new Maps($, scene, this.acts.pointing());
    this.peek = peek($(".peek"), $(".maps"), scene);
    this.panels = panels($(".panels"), () => {
      this.showToy();
      this.nodes.follow();
    });
    this.nodes = new Nodes($(".nodes"), scene, () => state.chapter === "analyse" && this.panels.open("nodes"));
    this.bar = orderBar($(".ride"), data.own);
    const toOrder = (p) => change({ p: scene.frames.orders[scene.frames.stop(p)] });
    const tall = () =>
      isLecture() ? 0.4 * innerHeight : Math.min(560, 0.24 * innerHeight + 0.5 * Math.max(0, innerHeight - 720));
    const high = () => (innerWidth < 820 ? 110 : state.chapter === "order" ? tall() : 0.165 * innerHeight);
    this.ride = new Curves($(".over"), toOrder, { measures: () => ["accuracy"], high });
    this.wave = new Wave($(".wave"));
    this.together = new Together($(".together"), toOrder);
    this.curves = new Curves($(".all"), toOrder, { measures: (frames) => gapsOf(frames).map(({ name }) => name) });
    this.stairs = new Staircase(
      $(".staircase"),
      () => state.stage,
      (stage) => change({ stage }),
    );
    this.strangers = new Strangers($, scene, {
      onCell: (cell) => this.acts.onlyCell(cell),
      onPick: (pair) => this.acts.pick(pair),
    });
    this.toy = new Toy($(".toy"));
    this.finder = new Finder($(".finder"), scene);
    this.saving = new Saving($, scene, this.maps, () => this.showPictures());
    this.announceSoon = afterwards(() => this.announce(), 400);
  }

  /** Facts about the set or its head have come. */
  learned() {
    const { facts, own, frames } = this.scene;
    own.columns = frames.columns = facts.pairs ?? {};
    this.maps.showColourings();
    if (facts.unseen) this.strangers.show();
    this.read();
    this.finder.show();
    this.showLesson();
    if (state.find || state.alike || state.range) this.refilter();
    if (facts.unseen && state.cell) this.strangers.follow();
    this.maps.beside.show();
    this.showPictures();
  }

  /** A chapter opens: nothing is selected, the whole map is in view. `pale` is the curve of another set. */
  start(frames, pale) {
    this.scene.selected = new Set();
    this.sample = frames.label.findIndex((label, pair) => frames.headless || label === frames.prediction[pair]);
    this.ride.pale = pale;
    this.maps.reset();
    this.replace(frames);
    this.acts.selectNamed();
    if (state.panel === "nodes") this.panels.show("nodes");
  }

  /** Show other frames of the same pairs. */
  replace(frames) {
    const { scene } = this;
    scene.frames = frames;
    frames.columns = scene.facts.pairs ?? {};
    scene.read();
    scene.follow();
    this.bar.replace(frames);
    this.bar.learned(state.chapter === "analyse" ? scene.own.learned : NaN); // the mark would give the answer away
    this.ride.hides = state.chapter === "order";
    this.ride.replace(frames);
    this.curves.replace(frames);
    if (state.chapter === "where") this.together.replace(frames);
    this.stairs.replace(frames);
    this.$(".mode-words").innerHTML = modeWords(frames);
    define(this.$(".mode-words"));
    Object.assign(this.$(".explore").dataset, { kind: frames.kind, can: modeOf(frames).can.join(" ") });
    this.$(".ride").classList.toggle("blind", !values(frames, "accuracy", "f_hat")?.some(Number.isFinite));
    this.showColours();
    this.showStage();
    this.showMeans();
    this.showToy();
  }

  /** Let the map show the points and the predictions of the chosen reading. */
  read() {
    this.scene.read();
    this.refilter();
  }

  showOrder() {
    const { scene } = this;
    scene.follow();
    this.bar.show(scene.stop);
    this.ride.mark(scene.stop);
    this.curves.mark(scene.stop);
    if (state.chapter === "where") this.together.mark(scene.stop);
    this.stairs.show(scene.stop);
    if (this.panels.open("toy")) this.toy.show(scene.p);
    this.nodes.follow();
    if (state.chapter === "order") this.wave.show(scene.p);
    if (ANSWERS.includes(colouring(scene.frames, state.colour).label)) this.maps.showLayers();
    this.maps.showNow();
    this.showCard();
    this.showLesson();
    this.announceSoon();
  }

  /** The words and figures of a chapter; in the workbench, the accuracy and whose it is. */
  showLesson() {
    const { scene } = this;
    const lesson = chapterNamed(state.chapter);
    const set = (selector, html) => fill(this.$(`.stage ${selector}`), html);
    if (!lesson) {
      const { frames, stop, facts } = scene;
      return set(
        ".score",
        frames.headless ? featuresHtml(scene) : headOf(frames, stop) + whence(frames, stop, facts.unseen),
      );
    }
    if (state.chapter === "where")
      return this.threads.tell(decided(scene.frames), whence(scene.frames, scene.stop, scene.facts.unseen));
    const words = lesson.words(scene);
    for (const name of ["title", "figure", "remark"]) set(`.${name}`, words[name]);
    set(".whence", words.whence ?? "");
    return undefined;
  }

  showStage() {
    const { frames } = this.scene;
    const steps = stepsOf(frames).map(({ key }) => key);
    if (!steps.includes(state.stage)) return change({ stage: frames.headless ? "raw" : "frft" }); // it lacks a projection
    this.stairs.choose();
    const stage = stageNamed(state.stage);
    this.$(".explain").innerHTML = `<b>${stage.name}.</b> ${explained(stage, frames)}`;
    define(this.$(".explain"));
    this.scene.near = [];
    this.maps.showKinds();
    this.showCurves();
    return this.showOrder();
  }

  showCurves() {
    for (const one of [this.ride, this.curves]) {
      one.show(state.stage, this.scene.loneDomain());
      one.mark(this.scene.stop);
    }
  }

  showColours() {
    this.maps.showColourings();
    showFilters(this.$(".filters"), this.scene.frames, (name) => {
      this.scene.highlight = name;
      this.maps.showLayers();
    });
    this.refilter();
  }

  /** Apply the filters everywhere: maps, titles, curves, selection, what is saved. */
  refilter() {
    if (this.scene.refilter()) this.acts.nameSelected();
    this.maps.showLayers();
    if (this.maps.now.frame) this.maps.showNow();
    this.showCurves();
    if (this.scene.facts.unseen) this.finder.count();
    this.showPictures();
  }

  showToy() {
    if (this.panels.open("toy")) this.toy.open().then(() => this.toy.show(this.scene.p));
  }

  showCard() {
    const { scene } = this;
    const pair = scene.hovered >= 0 ? scene.hovered % scene.frames.pairs : (state.pin ?? -1);
    const pinned = pair >= 0 && pair === state.pin;
    this.$('[data-panel="card"]').hidden = state.chapter !== "analyse" && state.pin === null;
    this.$(".card").innerHTML = card(
      scene.frames,
      scene.sprite,
      pair,
      scene.stop,
      pinned,
      this.sample,
      scene.facts.pairs,
    );
    if (pinned) this.acts.showNear();
  }

  showMeans() {
    press(this.$(".tool.means"), state.means === "1");
    press(this.$(".tool.second"), this.maps.beside.open);
    this.maps.paintMarks();
  }

  /** The pictures of what is selected or found. */
  showPictures() {
    showGrid(this.$(".pictures"), this.scene, {
      onPick: (pair) => this.acts.pick(pair),
      onClear: () => this.acts.select([]),
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
    this.$(".announcement").textContent = parts.join(", ");
  }
}
