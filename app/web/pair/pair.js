/** Try a pair: choose two images, see the prediction and its reliability. */

import { ask, attempt, isCancelled, json, readerOf, refused, visit } from "../shared/api.js";
import { ladder, loaded } from "../shared/facts.js";
import { needsHead } from "../shared/headless.js";
import { headLabel, heads } from "../shared/headsets.js";
import { IMAGES, OTHER } from "../shared/images.js";
import { onTheme } from "../shared/palette.js";
import { somePair } from "../shared/pick.js";
import { awaited } from "../shared/ready.js";
import { change, state, watch, watchIn } from "../shared/store.js";
import { fill } from "../shared/text.js";
import { theSetSoon } from "../shared/theset.js";
import { onClick, tell, View } from "../shared/view.js";
import { Live, liveHtml } from "./live.js";
import { loading } from "./loading.js";
import { Many } from "./many.js";
import { pairMap } from "./on-map.js";
import { OwnPairs } from "./own.js";
import { chosenFiles, droppedFiles, Known, takeLinked } from "./own-pictures.js";
import { readerHtml } from "./reader.js";
import { RealPairs } from "./real.js";
import { madeOf as profileOf, Sensor } from "./sensor.js";
import { Gallery, slots } from "./slots.js";
import { lineHtml, nextStep, stepOf } from "./steps.js";
import { isOwn, mixed, taughtBy } from "./tally.js";
import {
  cards,
  classTable,
  familiarHtml,
  madeOf,
  rivalsHtml,
  speakOfSignals,
  spoken,
  swapHtml,
  TERMS,
} from "./verdict.js";
import { WhatIf } from "./what-if.js";

const OWN = "own"; // the server's name of the head for own pictures

export async function start(root) {
  if (await needsHead(root)) return;
  let problem = "";
  const told = (error) => {
    refused(error, (sentence) => (problem = sentence));
    return [];
  };
  const [examples, set, found, unlinked, facts] = await Promise.all([
    json("examples").catch(() => []),
    theSetSoon(),
    heads().catch(told),
    takeLinked(),
    json("own").catch(told),
  ]);
  if ("left_out" in facts) visit.head = OWN;
  const tab = new PairTab(
    root,
    examples,
    set,
    found.filter((one) => one.name && !one.problem),
    unlinked,
    facts,
  );
  set.later?.then((late) => tab.adopt(late));
  if (!problem) return;
  tab.problem(problem);
  tab.$(".gallery").textContent = ""; // no map is being computed
}

class PairTab extends View {
  constructor(root, examples, set, rivals, unlinked, facts) {
    super(root);
    this.facts = facts; // of the head for own pictures; {} without one
    this.unlinked = unlinked; // what the address named and could not be had, until another pair is chosen
    this.examples = examples;
    this.set = set;
    this.rivals = rivals;
    this.answer = /** @type {any} */ (null);
    this.familiar = null;
    this.live = null; // the latest prediction of a camera picture
    this.asking = null;
    this.known = new Known(examples, set);
    this.whatIf = new WhatIf(this.$(".what-if-p"));
    this.own = new OwnPairs(this.$(".own"), {
      onAgain: () => {
        this.ask();
        this.many.again();
      },
      onLabel: () => this.showVerdict(),
      onChange: () => this.showLine(),
      onOpen: ({ vis, tac }) => change({ vis, tac }),
    });
    this.sending = 0; // uploads on the way
    this.many = new Many(this.$(".many"), {
      open: ({ vis, tac }) => change({ vis, tac }),
      labels: (pairs) => this.own.add(pairs),
      teach: () => this.own.teach(),
      lessons: () => this.own.lessons({}),
      profile: (photos, touches) => this.sensor.make(photos, touches),
      changed: (first) => this.dropped(first),
      classes: async () => (await loaded()).head.classes ?? [],
    });
    this.cameras = new Live(this.$(".cameras"), {
      answer: (found) => this.showLive(found),
      problem: this.problem,
      taught: async (fresh) => taughtBy(this.own.lessons({}), fresh),
      calibrate: (files) => this.sensor.take(files, "tac"),
      label: (pair, label) => this.own.count(pair, label, `live ${new Date().toLocaleTimeString()}`),
    });
    this.sensor = new Sensor(this.$(".sensor"), {
      pair: () => this.pair,
      again: () => {
        this.ask();
        this.many.again();
        this.showProfile();
      },
    });
    /** @type {any[]} */
    this.rungs = []; // what is known of a new sensor, and the accuracy that it brings
    this.gallery = new Gallery(this.$(".gallery"), this.$(".take"));
    this.real = new RealPairs(this.$(".real"), this.$(".take"), { onBusy: this.busy, onProblem: this.problem });
    this.showSlots = slots(this.$(".slots"), {
      onRef: (modality, ref) => change({ [modality]: ref }),
      onUpload: (modality, ref) => this.uploaded(modality, ref),
      onBusy: this.busy,
      onMany: (files) => this.many.take(files),
      onProblem: this.problem,
      lessons: () => this.own.lessons(this.pair),
    });
    loading(this.$(".loading"));
    this.$(".loading").open = state.panel === "loading";
    this.placeOnMap();
    this.gallery.fill(examples, set);
    this.wire();
    if (state.vis || state.tac) this.ask();
    else if (!unlinked) somePair(examples, set.frames); // which sends the request
    this.problem(unlinked);
    if (!state.vis && !state.tac) this.empty();
  }

  wire() {
    ladder().then(
      ({ rungs }) => {
        this.rungs = rungs;
        this.showLine();
      },
      () => {}, // a set without a ladder: no gain is named
    );
    watch(IMAGES, () => {
      this.unlinked = "";
      this.ask();
    });
    watchIn("pair", ["p"], () => this.whatIf.mark());
    watch(["view"], () => this.cameras.run && this.cameras.off());
    onTheme(() => this.whatIf.repaint());
    onClick(this.$(".familiar"), {
      "[data-pair]": ({ dataset: { pair } }) => change({ pin: +pair, vis: `row:${pair}`, tac: `row:${pair}` }),
      ".swap": () => change({ vis: state.tac, tac: state.vis }),
    });
    onClick(this.$(".reader"), { ".reader-switch": () => this.switchReader() });
    onClick(this.$(".started"), { button: () => change(/** @type {Partial<State>} */ (this.before)) });
    onClick(this.$(".profile-now"), { button: () => this.sensor.use("", null) });
    this.box.ondragover = (event) => event.preventDefault();
    this.box.ondrop = (event) => {
      event.preventDefault();
      awaited(droppedFiles(event.dataTransfer).then((files) => (files.length ? this.many.take(files) : undefined)));
    };
    for (const field of this.box.querySelectorAll(".pairs input")) {
      field.onchange = () => {
        const files = chosenFiles(field.files);
        if (files.length) awaited(this.many.take(files));
        field.value = "";
      };
    }
  }

  /** A new picture starts a new pair: nothing of a complete pair, or of an example, stays beside it. */
  uploaded(modality, ref) {
    const rest = OTHER[modality];
    const left = state[rest];
    const goes = left && (state[modality] || !isOwn({ [rest]: left }));
    this.before = { [rest]: left };
    change({ [modality]: ref, ...(goes && { [rest]: null }) });
    this.$(".started").hidden = !goes;
    this.$(".started span").textContent = `A new pair: the ${TERMS[rest].one} before it was taken away.`;
  }

  busy = (by) => {
    this.sending += by;
    this.settle();
  };

  /** A label waits until uploads and predictions are there. */
  settle() {
    this.own.hold(this.sending > 0 || this.$(".results").getAttribute("aria-busy") === "true");
  }

  placeOnMap() {
    this.box.classList.toggle("signals", Boolean(this.set.frames?.signals));
    if (this.set.frames?.signals) speakOfSignals();
    this.$(".line").hidden = Boolean(this.set.frames?.signals);
    this.$(".on-map").hidden = !this.set.frames;
    this.$(".of-signals").hidden = !this.set.frames?.signals;
    this.onMap = this.set.frames ? pairMap(this.$(".on-map"), this.set.frames) : null;
  }

  /** Many pairs are read: the first one takes the place of an example. */
  dropped(first) {
    if (first && !isOwn(this.pair)) change({ vis: first.vis, tac: first.tac });
    this.showLine();
  }

  /** The step in hand, and what the next one brings. */
  showLine() {
    if (!this.many) return; // not all parts are there yet
    const { pairs, report, inUse: used } = this.own;
    const at = stepOf({ dropped: this.many.rows.length > 0 || isOwn(this.pair), pairs, report, used });
    fill(
      this.$(".line"),
      lineHtml(
        at,
        nextStep(at, { pairs, report, counts: this.sensor?.counts, reader: visit.head && this.facts }, this.rungs),
      ),
    );
  }

  /** Own pictures are read by the head for them, or by that of the chapters; what was taught to one is not the other's. */
  switchReader() {
    visit.head = visit.head ? "" : OWN;
    this.own.changed(this.own.pairs);
    this.ask();
    this.many.again();
  }

  /** Which head has read an own pair. */
  showReader() {
    this.$(".reader").hidden = !this.facts.left_out || !isOwn(this.pair) || this.own.inUse;
    if (this.$(".reader").hidden) return;
    const used = Boolean(readerOf(this.pair));
    this.$(".reader").innerHTML = readerHtml(this.facts, used, this.own.learned);
  }

  /** A profile that acts on every prediction of own pictures is named beside them, and can be taken away. */
  showProfile() {
    const { counts } = this.sensor ?? {};
    this.$(".profile-now").hidden = !counts;
    if (counts)
      this.$(".profile-now span").textContent = `In use for your pictures: the profile of ${profileOf(counts)}.`;
    this.showLine();
  }

  problem = (sentence) => tell(this.$(".problem"), sentence, true);

  get pair() {
    return { vis: state.vis, tac: state.tac };
  }

  truths() {
    const own = isOwn(this.pair) ? this.own.labelOf(this.pair) : "";
    const of = (ref) => (ref ? this.known.of(ref).truth || own : "");
    return { vis: of(state.vis), tac: of(state.tac) };
  }

  showInputs() {
    this.showSlots(state, this.set.sprite, this.set.frames?.pairs ?? 0, (ref) => this.known.of(ref).text);
    for (const one of [this.gallery, this.real]) one.mark([state.vis, state.tac]);
    this.showLine();
  }

  /** A new pair or another head: request everything again. */
  async ask() {
    this.$(".started").hidden = true;
    this.showInputs();
    this.asking?.abort();
    if (!state.vis && !state.tac) return this.empty();
    const mine = (this.asking = new AbortController());
    const question = { ...this.pair, ...this.own.lessons(this.pair) };
    this.$(".results").setAttribute("aria-busy", "true");
    this.settle();
    const slow = setTimeout(() => this.say("Loading the head… the first prediction takes a few seconds."), 300);
    try {
      const answer = await ask("pair", question, mine.signal);
      this.problem(this.unlinked);
      this.answer = answer;
      this.familiar = null;
      this.showAnswer(question);
      this.askMore(mine.signal);
    } catch (error) {
      refused(error, (sentence) => {
        this.problem(sentence);
        this.empty();
      });
    } finally {
      clearTimeout(slow);
      if (this.asking === mine) this.$(".results").setAttribute("aria-busy", "false"); // otherwise a newer request is running
      this.settle();
    }
  }

  /** Results after the first prediction: familiarity, other heads, the place on the map. */
  async askMore(signal) {
    const { pair } = this;
    this.onMap?.(pair, this.orderShown());
    const quietly = (asked) =>
      asked.catch((error) => {
        if (isCancelled(error)) throw error;
        return { problem: error.message };
      });
    await attempt(async () => {
      const others = this.rivals.map((one) => quietly(ask("pair", { ...pair, head: one.name }, signal)));
      const own = this.own.lessons(pair);
      const familiar = await quietly(ask("familiar", { ...pair, ...own }, signal));
      this.familiar = familiar.problem
        ? { images: {}, problem: familiar.problem }
        : { ...familiar, yours: Boolean(own.lessons) };
      this.showFamiliar();
      this.showVerdict();
      this.whatIf.know(this.familiar.images);
      this.$(".sr").textContent = spoken(this.answer, this.familiar);
      this.showRivals(await Promise.all(others));
    }, this.problem);
  }

  showRivals(found) {
    const labelled = found.map((one, i) => ({ ...one, label: headLabel(this.rivals[i]) }));
    this.$(".rivals").hidden = !found.length;
    this.$(".rivals").innerHTML = found.length ? rivalsHtml(this.answer, labelled, this.familiar?.images) : "";
  }

  /** The order of the map: that of the head which it shows, if linear maps have decided. */
  orderShown() {
    return this.answer.linear ? null : this.answer.learned;
  }

  showAnswer(question) {
    this.showVerdict();
    this.showReader();
    this.sensor.compare();
    this.own.show(this.pair, this.answer.classes, (pair) => this.known.name(pair));
    this.whatIf.show(this.answer, question);
  }

  showVerdict() {
    if (!this.answer || this.live) return;
    const truths = this.truths();
    const taught = this.own.inUse
      ? `<p class="taught-now"><b class="tag">taught</b> by your ${this.own.labelOf(this.pair) ? "other pairs; this one was left out" : "pairs"}.</p>`
      : "";
    const mix = mixed(this.pair)
      ? '<p class="made-of">Two pictures of different pairs: not counted, not taught.</p>'
      : "";
    this.$(".verdict").innerHTML = `${taught}${madeOf(truths) || mix}${cards(this.answer, this.familiar, truths)}
      <details class="all-classes"><summary>Every class</summary><div class="bars">${classTable(this.answer.classes, this.answer.exact.readings, this.familiar?.images)}</div><p class="hint">${this.answer.linear ? "By linear maps, in which p has no part." : `At the learned p = ${this.answer.learned.toFixed(4)}.`}</p></details>`;
    this.$(".all-classes").open = this.allClasses ?? false;
    this.$(".all-classes").ontoggle = (event) => (this.allClasses = event.target.open);
  }

  showFamiliar() {
    this.$(".familiar").hidden = !this.familiar;
    if (!this.familiar) return;
    this.$(".familiar").innerHTML = this.familiar.problem
      ? `<p class="hint"></p>`
      : (this.set.frames?.signals ? "" : swapHtml(this.familiar.images)) + familiarHtml(this.familiar, this.set);
    if (this.familiar.problem) this.$(".familiar p").textContent = this.familiar.problem;
  }

  /** Show the latest camera prediction; null shows the pair's again. */
  showLive(found) {
    const was = this.live;
    this.live = found;
    if (!found) return was ? this.ask() : this.showInputs(); // the images in place of the camera
    this.$(".verdict").innerHTML = liveHtml(found);
  }

  say(sentence) {
    this.$(".verdict").innerHTML = '<p class="hint"></p>';
    this.$(".verdict p").textContent = sentence;
  }

  empty() {
    this.answer = null;
    this.say("Choose a pair to see the prediction. One image is enough.");
    for (const name of [".familiar", ".rivals", ".reader"]) this.$(name).hidden = true;
    this.own.show(this.pair);
    this.whatIf.show(null);
  }

  /** The set has arrived after the first prediction: show its pictures, pairs and map. */
  adopt(late) {
    this.set = late;
    this.known = new Known(this.examples, late);
    this.placeOnMap();
    this.gallery.fill(this.examples, late);
    this.showInputs();
    if (this.answer) {
      this.showFamiliar();
      this.showVerdict();
      this.onMap?.(this.pair, this.orderShown());
    }
    if (!this.unlinked) somePair(this.examples, late.frames);
  }
}
