/** The guided tour through the chapters. The visitor predicts, then the tour shows the result. */

import { choices, framesOf, twins, twinsMap, unseen } from "../shared/facts.js";
import { setOf } from "../shared/sets.js";
import { change, openChapter, state } from "../shared/store.js";
import { OWN_MODE } from "../shared/tables.js";
import { openTab } from "../shared/tabs.js";
import { each } from "../shared/text.js";
import { theSet } from "../shared/theset.js";
import { onScreen, STEPS } from "./steps.js";

/** Start the tour; throws a Refusal if a set or its head cannot be read. */
export async function startTour() {
  if (document.querySelector(".tour")) return;
  const { sets, twins: there } = await choices();
  const [first, second] = ["order", "fooled"].map((chapter) => setOf(chapter, sets));
  const none = () => null;
  const [{ frames: own }, { modes }, strangers, made, places] = await Promise.all([
    theSet(() => {}, first),
    choices(first),
    unseen(second).catch(() => ({ domains: [], unseen: {} })),
    there ? twins().catch(none) : null,
    there ? twinsMap().catch(none) : null,
  ]);
  const frames = modes[0] === OWN_MODE ? own : await framesOf(modes[0], own, first);
  const pale = sets.find(({ name }) => name === "sensors" && first !== second)?.curve?.share ?? null;
  openTab("explore");
  const figures = onScreen(frames, { unseen: strangers, pale, twins: made, places });
  new Tour(document.querySelector(".explore"), figures).show();
}

class Tour {
  constructor(explore, figures) {
    this.figures = figures;
    this.steps = STEPS.filter(({ needs }) => !needs || figures[needs]);
    this.at = 0;
    this.before = state.chapter;
    this.explore = explore;
    this.box = document.createElement("div");
    this.box.className = "ov tour";
    this.box.setAttribute("role", "dialog");
    this.box.setAttribute("aria-label", "Guided tour");
    this.explore.classList.add("touring");
    this.box.onclick = (event) => this.click(/** @type {HTMLElement} */ (event.target));
    this.box.onkeydown = (event) => {
      if (event.key === "Escape") this.end(); // return nothing: false would cancel the Enter key
    };
  }

  /** Set the page for a step and show its question; what would answer it is hidden, and rests. */
  show() {
    const step = this.steps[this.at];
    openChapter(step.chapter, step.set);
    this.explore.querySelector(step.chapter === "touch" ? ".touch .side" : ".stage .side").prepend(this.box); // in the flow
    if (!step.ask) return this.tell(step, "");
    this.asking(true);
    const options = each(
      step.options,
      ([key, words]) => `<button type="button" data-option="${key}">${words}</button>`,
    );
    this.lay(step, `<p>${step.ask}</p>`, `<span class="options">${options}</span>`);
    return this.focus("h3");
  }

  /** Hide the figures and let the controls rest, or not. */
  asking(on) {
    this.explore.classList.toggle("asking", on);
    for (const part of this.explore.querySelectorAll(".chapters, .press, .map-panel, .side > :not(.tour)"))
      part.inert = on;
  }

  /** Show the result, and whether the prediction was correct. */
  reveal(option) {
    const step = this.steps[this.at];
    const right = step.right(this.figures);
    const words = (key) => step.options.find(([own]) => own === key)?.[1];
    const verdict = !right.length
      ? ""
      : right.includes(option)
        ? '<b class="right">As you predicted.</b> '
        : `<b class="wrong">Not so. Correct: “${right.map(words).join("”, “")}”.</b> `;
    this.tell(step, verdict);
  }

  tell(step, verdict) {
    this.asking(false);
    if (step.after) change(step.after(this.figures));
    this.lay(
      step,
      `<p>${verdict}${step.reveal(this.figures)}</p>`,
      `<button type="button" class="main next-step">${this.at + 1 < this.steps.length ? "Next" : "Done"}</button>`,
    );
    this.focus(".next-step");
  }

  focus(selector) {
    /** @type {HTMLElement} */ (this.box.querySelector(selector)).focus({ preventScroll: true });
  }

  lay(step, text, buttons) {
    this.box.innerHTML = `<div aria-live="polite"><h3 tabindex="-1">${this.at + 1} of ${this.steps.length} · ${step.title}</h3>${text}</div>
      <div class="row">${buttons}<span class="spring"></span><button type="button" class="back" ${this.at ? "" : "disabled"}>Back</button><button type="button" class="end" aria-label="End the tour">✕</button></div>`;
  }

  click(target) {
    if (target.dataset.option) return this.reveal(target.dataset.option);
    if (target.matches(".end") || (target.matches(".next-step") && this.at + 1 === this.steps.length))
      return this.end();
    if (target.matches(".next-step")) this.at += 1;
    else if (target.matches(".back")) this.at -= 1;
    else return undefined;
    return this.show();
  }

  end() {
    this.box.remove();
    this.asking(false);
    this.explore.classList.remove("touring");
    openChapter(this.before);
  }
}
