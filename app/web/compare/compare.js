/** Compare: two heads, or two stages of one, on the same pairs; linked by pointer, lasso and view. */

import { refused } from "../shared/api.js";
import { saidHtml, thumbnailPair, verdict } from "../shared/card.js";
import { unseen } from "../shared/facts.js";
import { shownBy } from "../shared/filters.js";
import { needsHead } from "../shared/headless.js";
import { heads, isMethod, methodsFor } from "../shared/headsets.js";
import { COLOURINGS, onTheme } from "../shared/palette.js";
import { stageNamed } from "../shared/stages.js";
import { change, state, watch, watchIn } from "../shared/store.js";
import { each, escaped, options } from "../shared/text.js";
import { theSet } from "../shared/theset.js";
import { making, press, tell, View } from "../shared/view.js";
import { counted, sentence } from "./changes.js";
import { matrix } from "./matrix.js";
import { SIDES, Side, sideHtml } from "./side.js";

export async function start(root) {
  if (await needsHead(root)) return;
  const wait = root.querySelector(".wait");
  try {
    const { frames, sprite } = await theSet((step) => tell(wait, making(step)));
    tell(wait, "");
    const tab = new CompareTab(root, frames, sprite, await heads().catch(() => []));
    matrix(root.querySelector(".matrix"));
    unseen().then(
      (found) => tab.judge(found),
      () => {},
    );
  } catch (error) {
    refused(error, (sentence) => tell(wait, sentence, true));
  }
}

/** Initially both sides are at the learned p: left the next head or nearest class mean, right the head. */
function atFirst(frames, known) {
  const learned = frames.orders[frames.stop(frames.meta.head?.learned_order ?? 0.5)];
  if (state.p === null) state.p = learned;
  if (state.p2 === null) {
    state.p2 = learned;
    if (!state.head2 && !state.only2) {
      state.head2 = known.find((one) => one.name && !one.problem)?.name ?? methodsFor(frames)[0]?.[0] ?? "";
      if (!isMethod(state.head2)) state.stage2 = state.head2 ? "f_hat" : "raw";
    }
  }
  state.stage2 = stageNamed(state.stage2).key;
}

class CompareTab extends View {
  constructor(root, frames, sprite, known) {
    super(root);
    this.frames = frames;
    this.sprite = sprite;
    this.judged = null; // test pairs, once loaded
    this.hovered = -1;
    this.selected = new Set();
    this.lassoed = new Set(); // classes of the selection
    this.lassoMode = false;
    this.changedOnly = false;
    this.shown = shownBy(frames);
    this.sides = [];
    atFirst(frames, known);
    this.$(".sides").innerHTML = each(SIDES, (keys) => sideHtml(keys, frames, known));
    SIDES.forEach((keys, i) => this.sides.push(new Side(keys, this.$(".sides").children[i], frames, this)));
    this.wire();
    this.show();
    this.load();
  }

  wire() {
    this.$(".colouring").innerHTML = options(Object.entries(COLOURINGS).map(([key, c]) => [key, c.label]));
    this.$(".colouring").onchange = (event) => change({ colour: event.target.value });
    this.$(".reset").onclick = () => this.sides[0].cloud.resetView();
    this.$(".lasso").onclick = (event) => press(event.currentTarget, (this.lassoMode = !this.lassoMode));
    this.$(".changed").onclick = (event) => {
      press(event.currentTarget, (this.changedOnly = !this.changedOnly));
      this.show();
    };
    watchIn("compare", ["p", "p2", "stage", "stage2", "map", "colour", "only", "only2"], () => this.show());
    watch(["head", "head2"], () => this.load());
    watch(["domain", "class", "modality"], () => {
      this.shown = shownBy(this.frames);
      this.show();
    });
    watch(["pin"], () => this.mark());
    onTheme(() => this.show());
  }

  /** The test pairs: not used in training, and of a class that the head has. */
  judge({ pairs }) {
    this.judged = Array.from(pairs.counts.keys()).filter((pair) => pairs.counts[pair]);
    this.show();
  }

  async load() {
    await Promise.all(this.sides.map((side) => side.load(this.frames, () => this.load())));
    this.show();
  }

  /** True if the two sides show different domains, and so share no pairs. */
  get apart() {
    return state.only && state.only2 && state.only !== state.only2;
  }

  get hoveredPair() {
    return this.hovered < 0 ? null : this.hovered % this.frames.pairs;
  }

  truth = (pair) => this.frames.classes[this.frames.label[pair]];

  inPlay(point) {
    const pair = point % this.frames.pairs;
    const [left, right] = this.sides;
    return this.shown(point) && (!this.changedOnly || left.said(pair) !== right.said(pair));
  }

  lit(pair) {
    return !this.selected.size || this.selected.has(pair) || (this.apart && this.lassoed.has(this.frames.label[pair]));
  }

  show() {
    for (const side of this.sides) side.show();
    this.$(".colouring").value = state.colour;
    this.$(".moved").innerHTML = this.moved();
    this.mark();
  }

  moved() {
    if (this.apart) {
      return `${escaped(state.only2)} and ${escaped(state.only)} share no pairs: a selection in one highlights the same classes in the other.`;
    }
    if (this.sides.some((side) => side.failed)) return "One side has no predictions; its reason is above its map.";
    if (!this.judged || !this.sides.every((side) => side.ready)) return "Counting…";
    const only = state.only || state.only2;
    const { frames } = this;
    const pairs = this.judged.filter((pair) => !only || frames.domains[frames.domain[pair]] === only);
    const [left, right] = this.sides;
    return sentence([left.who, right.who], counted(pairs, left.said, right.said, this.truth));
  }

  mark() {
    for (const { cloud } of this.sides) cloud.paintMarks();
    this.showCard();
  }

  showCard() {
    const { frames, sprite } = this;
    const pair = this.hoveredPair ?? state.pin ?? -1;
    const strip = this.$(".card-strip");
    if (pair < 0) {
      strip.innerHTML = `${thumbnailPair(frames, sprite, 0, 84)}<p class="hint">Point at a pair in either map to see its photo, its touch and both predictions.</p>`;
      return;
    }
    const said = this.sides.map((side) => {
      const v = verdict(side.frames, pair, side.stop);
      return `<dt>${side.keys.name}</dt><dd class="${v.right ? "right" : "wrong"}">${saidHtml(v)}</dd>`;
    });
    strip.innerHTML = `${thumbnailPair(frames, sprite, pair, 84)}<div><h3>Pair ${pair}</h3><dl><dt>${escaped(frames.domains[frames.domain[pair]])}</dt><dd>${escaped(this.truth(pair))}</dd>${said.join("")}</dl></div>`;
  }

  hover(point) {
    if (point === this.hovered) return;
    this.hovered = point;
    this.mark();
  }

  step(by) {
    const total = 2 * this.frames.pairs;
    this.hover((Math.max(this.hovered, 0) + by + total) % total);
  }

  pick(point) {
    if (point < 0) return change({ pin: null });
    const pair = point % this.frames.pairs;
    change({ pin: pair, vis: `row:${pair}`, tac: `row:${pair}` });
  }

  /** A lasso selects whole pairs, so that both points are highlighted on both sides. */
  select(points) {
    this.selected = new Set(points.map((point) => point % this.frames.pairs));
    this.lassoed = new Set([...this.selected].map((pair) => this.frames.label[pair]));
    this.show();
  }

  follow(from, view) {
    for (const side of this.sides) if (side !== from) side.cloud.setView(view, true);
  }
}
