/** Try a pair: choose two images, see the prediction and its reliability. */

import { attempt, json, readerOf, refused, visit } from "../shared/api.js";
import { ladder, loaded } from "../shared/facts.js";
import { needsHead } from "../shared/headless.js";
import { heads } from "../shared/headsets.js";
import { held } from "../shared/held.js";
import { onTheme } from "../shared/palette.js";
import { somePair } from "../shared/pick.js";
import { awaited } from "../shared/ready.js";
import { change, state, watch, watchIn } from "../shared/store.js";
import { theSetSoon } from "../shared/theset.js";
import { View } from "../shared/view.js";
import { Feed, feedHtml } from "./feed.js";
import { controlsHtml } from "./live.js";
import { loading } from "./loading.js";
import { manyHtml } from "./many.js";
import { pairMap } from "./on-map.js";
import { ownHtml } from "./own.js";
import { chosenFiles, droppedFiles, takeLinked } from "./own-pictures.js";
import {
  button,
  drawPart,
  fill,
  hint,
  html,
  IMAGES,
  madeOf,
  mendedBy,
  opener,
  put,
  speakOfSignals,
  TERMS,
} from "./parts.js";
import { cautionOf, readerHtml } from "./reader.js";
import { realHtml } from "./real.js";
import { Relief } from "./relief.js";
import { galleryHtml, slotsHtml } from "./slots.js";
import { after, isOwn, START } from "./state.js";
import { lineHtml } from "./steps.js";
import { classTable, familiarHtml, rivalsHtml, spoken, swapHtml, verdictHtml } from "./verdict.js";
import { WhatIf } from "./what-if.js";
import { tint } from "./where.js";
import { NOTES, restore, TOGETHER, WORK } from "./work.js";

const SENSOR = ".sensor .lots"; // whose script comes when it is opened

/** Each part of the tab: null hides it, undefined leaves it until something new is there.
 * @type {Record<string, (tab: PairTab) => Html | null | undefined>} */
const PARTS = {
  ".problem": ({ notes }) => (notes.problem ? html`${notes.problem}` : null),
  ".profile-now": ({ counts, mend }) =>
    counts || mend
      ? html`${
          counts &&
          html`The profile of ${madeOf(counts)} is applied to your
        pictures. ${button("profileDropped", "Stop using it")} `
        }
        ${mend && html`Your touches are read ${mendedBy(mend)}. ${button("mended", "Read them as they come")}`}`
      : null,
  ".started": ({ away }) =>
    away &&
    html`You started a new pair, so the ${TERMS[away.vis ? "vis" : "tac"].one} of the old one was
      removed. ${opener("Put it back", away)}`,
  ".slots": slotsHtml,
  ".controls": controlsHtml,
  ".gallery": galleryHtml,
  ".real": realHtml,
  ".many": manyHtml,
  ".predicted": verdictHtml,
  ".bars": ({ answer, frame }) => (answer && !frame ? classTable(answer) : null),
  ".reader": ({ answer, facts, taught, source, ...tab }) => {
    const which = facts.left_out && isOwn(tab) && !taught;
    if (!answer || !(which || answer.touch)) return null;
    return html`${which && readerHtml(facts, Boolean(readerOf({ vis: tab.vis, tac: tab.tac })), source)}
      ${answer.touch && hint(`Touch is read ${answer.touch}.`)}`;
  },
  ".familiar": ({ answer, familiar, set, question, ...pair }) => {
    if (!answer) return null;
    if (!familiar) return hint("Looking for the nearest training images…");
    if ("problem" in familiar) return hint(familiar.problem);
    const looks = familiarHtml(familiar, answer.images, set, Boolean(question?.lessons));
    return html`${!set.frames?.signals && swapHtml(familiar.images, pair)}${looks}`;
  },
  ".own": ownHtml,
  ".rivals": ({ answer, rivals, heads }) => {
    if (!answer || !heads.length) return null;
    return rivals ? rivalsHtml(answer, rivals) : hint("Reading this pair by the other heads…");
  },
  ".aloud": (tab) => (tab.answer ? html`${spoken(tab.answer, (said) => cautionOf(tab, said))}` : undefined),
};

/** The tab on the screen: it takes events, draws what they make of the tab, and has the work done that follows. */
class PairView extends View {
  /** @param {HTMLElement} root @param {Partial<PairTab>} tab */
  constructor(root, tab) {
    super(root);
    /** @type {PairTab} */
    this.tab = { ...START, ...tab, vis: state.vis, tac: state.tac };
    /** @type {Partial<Record<keyof PairWork, AbortController>>} */
    this.running = {};
    this.whatIf = new WhatIf(this.$(".what-if-p"), (curves) => this.send("arrived", { curves }));
    this.relief = new Relief(this.$(".relief"), () => this.tab);
    put(this.$(".feeds"), html`${IMAGES.map(feedHtml)}`);
    this.feeds = [...root.querySelectorAll(".feed")].map(
      (box) => new Feed(/** @type {HTMLElement} */ (box), (line) => this.send("arrived", { line })),
    );
    /** @type {Desk["map"]} */
    this.map = null;
    loading(this.$(".loading"));
    const sensor = /** @type {HTMLDetailsElement} */ (this.$(".sensor"));
    sensor.ontoggle = async () => {
      if (!sensor.open || PARTS[SENSOR]) return;
      PARTS[SENSOR] = (await awaited(import("./sensor.js"))).sensorHtml;
      this.draw();
    };
    this.listen();
    this.draw();
  }

  /** @template {keyof PairEvents | keyof PairWork} Name @param {Name} name
   * @param {(PairEvents & PairWork)[Name]} detail */
  send = (name, detail) => {
    const { tab, next, halt } = after(this.tab, name, detail);
    this.tab = tab;
    const { vis, tac, head, profile, mend, lit } = tab;
    Object.assign(visit, { head, profile, mend, lit: lit ? profile : "" });
    for (const work of halt) this.running[work]?.abort();
    change({ vis, tac, p: state.p ?? tab.answer?.learned ?? null });
    this.draw();
    for (const [work, what] of Object.entries(next)) this.work(/** @type {keyof PairWork} */ (work), what);
  };

  /** Do some work; a newer one of its kind stops it, unless they go TOGETHER. @param {keyof PairWork} name
   * @param {any} what */
  async work(name, what) {
    const beside = TOGETHER.includes(name);
    if (!beside) this.running[name]?.abort();
    const { signal } = (this.running[name] = new AbortController());
    /** @type {Desk["send"]} */
    const send = (event, detail) => signal.aborted || this.send(event, detail);
    try {
      await WORK[name](Object.assign(Object.create(this), { send }), what, signal);
    } catch (error) {
      refused(error, (/** @type {string} */ sentence) =>
        name === "predict" ? send("failed", sentence) : send("noted", { [NOTES[name] ?? "problem"]: sentence }),
      );
    } finally {
      send("doing", { [(beside && what.modality) || name]: undefined });
    }
  }

  draw() {
    const { tab } = this;
    const { frames } = tab.set;
    if (frames && !this.map) {
      if (frames.signals) speakOfSignals();
      this.$(".on-map").hidden = false;
      this.map = pairMap(this.$(".on-map"), frames);
    }
    this.box.classList.toggle("signals", Boolean(frames?.signals));
    fill(this.$(".line"), lineHtml(tab));
    for (const [part, markup] of Object.entries(PARTS)) drawPart(this.$(part), markup(tab));
    for (const canvas of this.box.querySelectorAll(".slot canvas")) {
      const parts = tab.explained[/** @type {Modality} */ (canvas.closest(".slot").dataset.modality)];
      if (parts) tint(canvas, parts);
    }
    this.$(".results").setAttribute("aria-busy", String(tab.busy));
    this.$(".desk").classList.toggle("live", tab.on);
    this.whatIf.show(tab);
    awaited(this.relief.show());
  }

  listen() {
    const { box, send } = this;
    box.onclick = (/** @type {Found} */ { target }) => {
      const dataset = target.closest("button[data-send]")?.dataset;
      if (dataset) send(dataset.send, dataset);
    };
    box.onchange = (/** @type {Found} */ { target }) => {
      const { send: event, ...detail } = target.dataset;
      if (!event) return;
      if (target.type !== "file") return send(event, { ...detail, [target.name]: target.value });
      const files = chosenFiles(target.files);
      target.value = "";
      if (files.length) send(event, { ...detail, files });
    };
    box.onsubmit = (/** @type {Found} */ event) => {
      event.preventDefault();
      send("answered", { label: event.target.elements.label.value.trim() });
      event.target.reset();
    };
    const slotOf = (/** @type {Found} */ { target }) => target.closest(".slot, [data-drop]");
    box.ondragover = (/** @type {DragEvent} */ event) => {
      event.preventDefault();
      slotOf(event)?.classList.add("over");
    };
    box.ondragleave = (/** @type {DragEvent} */ event) => slotOf(event)?.classList.remove("over");
    /** @param {Found} event @param {Chosen[] | Promise<Chosen[]>} given */
    const taken = async (event, given) => {
      const slot = slotOf(event);
      slot?.classList.remove("over");
      const files = await given;
      if (files.length) send(slot?.dataset.drop ?? "dropped", { files, ...slot?.dataset });
    };
    box.ondrop = (/** @type {Found} */ event) => {
      event.preventDefault();
      awaited(taken(event, droppedFiles(event.dataTransfer)));
    };
    box.onpaste = (/** @type {Found} */ event) =>
      slotOf(event)?.dataset.modality && taken(event, chosenFiles(event.clipboardData.files).slice(0, 1));
    watch(IMAGES, () => {
      const { vis, tac } = state;
      if (vis !== this.tab.vis || tac !== this.tab.tac) send("opened", { vis, tac });
    });
    watchIn("pair", ["p"], () => this.whatIf.show());
    watch(["view"], () => this.tab.on && send("camerasOff", ""));
    onTheme(() => this.whatIf.repaint());
  }
}

/** @param {HTMLElement} root */
export async function start(root) {
  if (await needsHead(root)) return;
  let problem = "";
  const note = (/** @type {string} */ sentence) => (problem = sentence);
  const [examples, set, all, { lost, sent }, facts] = await Promise.all([
    json("examples").catch(() => []),
    theSetSoon(),
    attempt(heads, note),
    takeLinked(),
    attempt(() => json("own"), note),
  ]);
  const desk = new PairView(root, {
    examples,
    facts: facts ?? {},
    head: facts?.left_out ? "own" : "",
    heads: (all ?? []).filter((one) => one.name && !one.problem),
    lost,
    sent,
    notes: { ...START.notes, problem: problem || lost },
    set: { ...set, gone: Boolean(problem) },
  });
  const { send } = desk;
  const begin = () => lost || somePair(examples, desk.tab.set.frames);
  visit.renew = () => restore(desk);
  visit.seen = (pictures) => send("seen", pictures);
  restore(desk);
  set.later?.then((late) => {
    send("arrived", { set: late });
    begin();
  });
  const quiet = () => {}; // a set without a ladder: no gain is named; the page itself reports a lost set
  attempt(async () => send("arrived", { rungs: (await ladder()).rungs }), quiet);
  attempt(async () => {
    const { head, embeddings } = await loaded();
    send("arrived", { source: head.source, tested: head.real ?? null, simulated: embeddings.simulated });
  }, quiet);
  if (!held)
    attempt(
      async () => send("arrived", { real: await json("real") }),
      (/** @type {string} */ sentence) => send("noted", { problem: sentence }),
    );
  if (state.vis || state.tac) send("again", {});
  else begin();
}
