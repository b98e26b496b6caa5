/** The guided tour: six steps through the chapters. The visitor predicts, then the tour shows the result. */

import { centred, choices, framesOf, ladder, unseen } from "../shared/facts.js";
import { setOf } from "../shared/sets.js";
import { change, openChapter, state } from "../shared/store.js";
import { openTab } from "../shared/tabs.js";
import { each } from "../shared/text.js";
import { theSet } from "../shared/theset.js";
import { onScreen, STEPS } from "./steps.js";

/** Start the tour; throws a Refusal if a set or its head cannot be read. */
export async function startTour() {
  if (document.querySelector(".tour")) return;
  const { sets } = await choices();
  const [first, second] = ["order", "failure"].map((chapter) => setOf(chapter, sets));
  const [{ frames: own }, { modes }, strangers, gaps] = await Promise.all([
    theSet(() => {}, first),
    choices(first),
    unseen(second).catch(() => ({ domains: [], unseen: {} })),
    centred.pca(second).then(
      ({ curves }) => curves["domain_gap/raw"],
      () => null,
    ),
  ]);
  const frames = modes[0] === "moved" ? own : await framesOf(modes[0], own, first);
  const pale = sets.find(({ name }) => name === "sensors" && first !== second)?.curve?.share ?? null;
  openTab("explore");
  const figures = onScreen(frames, { unseen: strangers, gaps, pale });
  const climbing = ladder(second).then(
    (found) => climb(second, found, figures),
    () => {}, // the last step then leaves these figures out
  );
  new Tour(document.querySelector(".explore"), figures, climbing).show();
}

/** Add the ladder of the loaded head to the figures; later, what 20 pictures bring to light heads from other sources. */
function climb(set, { rungs, sources }, figures) {
  figures.rungs = rungs;
  others(set, rungs, sources).then(
    (gains) => (figures.records = gains),
    () => {},
  );
}

async function others(set, rungs, sources) {
  const gains = [];
  for (const source of sources.filter((name) => name !== rungs[0]?.source)) {
    const { rungs: found } = await ladder(set, source);
    const [none, n20] = ["none", "n20"].map((wanted) => found.find(({ rung }) => rung === wanted));
    if (none && n20 && !n20.known.endsWith(")")) gains.push(n20.accuracy - none.accuracy); // another method is named in brackets
  }
  return gains;
}

class Tour {
  constructor(explore, figures, climbing) {
    this.figures = figures;
    this.climbing = climbing; // until the ladder is known
    this.at = 0;
    this.before = state.chapter;
    this.explore = explore;
    this.box = document.createElement("div");
    this.box.className = "ov tour";
    this.box.setAttribute("role", "dialog");
    this.box.setAttribute("aria-label", "Guided tour");
    explore.querySelector(".side").prepend(this.box); // in the flow, so that it covers nothing
    this.explore.classList.add("touring");
    this.box.onclick = (event) => this.click(/** @type {HTMLElement} */ (event.target));
    this.box.onkeydown = (event) => {
      if (event.key === "Escape") this.end(); // return nothing: false would cancel the Enter key
    };
  }

  /** Set the page for a step and show its question. */
  show() {
    const step = STEPS[this.at];
    openChapter(step.chapter, { rung: "0" });
    const options = each(
      step.options,
      ([key, words]) => `<button type="button" data-option="${key}">${words}</button>`,
    );
    this.lay(step, `<p>${step.ask}</p>`, `<span class="options">${options}</span>`);
    this.focus("[data-option]");
  }

  /** Show the result, and whether the prediction was correct. */
  async reveal(option) {
    const step = STEPS[this.at];
    if (step.climbs) {
      this.lay(step, "<p>Computing the head’s accuracy with 20 pictures…</p>", "");
      await this.climbing;
      if (STEPS[this.at] !== step || !this.box.isConnected) return; // the visitor went on
    }
    const right = step.right(this.figures);
    const words = (key) => step.options.find(([own]) => own === key)?.[1];
    const verdict = !right.length
      ? ""
      : right.includes(option)
        ? '<b class="right">As you predicted.</b> '
        : `<b class="wrong">Not so. Correct: “${right.map(words).join("”, “")}”.</b> `;
    if (step.after) change(step.after(this.figures));
    this.lay(
      step,
      `<p>${verdict}${step.reveal(this.figures)}</p>`,
      `<button type="button" class="main next-step">${this.at + 1 < STEPS.length ? "Next" : "Done"}</button>`,
    );
    this.focus(".next-step");
  }

  lay(step, text, buttons) {
    this.box.innerHTML = `<div aria-live="polite"><h3>${this.at + 1} of ${STEPS.length} · ${step.title}</h3>${text}</div>
      <div class="row">${buttons}<span class="spring"></span><button type="button" class="back" ${this.at ? "" : "disabled"}>Back</button><button type="button" class="end" aria-label="End the tour">✕</button></div>`;
  }

  focus(selector) {
    /** @type {HTMLElement} */ (this.box.querySelector(selector)).focus({ preventScroll: true });
  }

  click(target) {
    if (target.dataset.option) return this.reveal(target.dataset.option);
    if (target.matches(".end") || (target.matches(".next-step") && this.at + 1 === STEPS.length)) return this.end();
    if (target.matches(".next-step")) this.at += 1;
    else if (target.matches(".back")) this.at -= 1;
    else return undefined;
    return this.show();
  }

  end() {
    this.box.remove();
    this.explore.classList.remove("touring");
    openChapter(this.before);
  }
}
