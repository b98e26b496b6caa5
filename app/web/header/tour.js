/** The guided tour: six steps in Explore. The visitor predicts, then the tour shows the result. */

import { choices, framesOf, toyFacts, unseen } from "../shared/facts.js";
import { change, state } from "../shared/store.js";
import { openTab } from "../shared/tabs.js";
import { theSet } from "../shared/theset.js";
import { onScreen, STEPS } from "./steps.js";

const KEPT = [
  "stage",
  "colour",
  "map",
  "part",
  "gap",
  "reading",
  "mode",
  "means",
  "domain",
  "class",
  "modality",
  "alike",
  "find",
  "range",
  "cell",
];

/** Start the tour; throws a Refusal if the set or its head cannot be read. */
export async function startTour() {
  if (document.querySelector(".tour")) return;
  const [{ frames: own }, { modes }, strangers, toy] = await Promise.all([
    theSet(),
    choices(),
    unseen(),
    toyFacts(),
  ]);
  const frames = modes[0] === "moved" ? own : await framesOf(modes[0], own);
  const tour = new Tour(frames, { unseen: strangers, toy });
  openTab("explore");
  if (Number.isFinite(own.learned)) change({ p: frames.orders[frames.stop(own.learned)] });
  tour.show();
}

/** True if all of an element is above the tour's box and below the top. */
function inView(element, box) {
  const { top, bottom } = element.getBoundingClientRect();
  return top >= 0 && bottom <= box.getBoundingClientRect().top;
}

class Tour {
  constructor(frames, facts) {
    this.frames = frames;
    this.facts = facts;
    this.at = 0;
    this.before = Object.fromEntries(KEPT.map((name) => [name, state[name]]));
    this.box = document.createElement("div");
    this.box.className = "ov tour";
    this.box.setAttribute("role", "dialog");
    this.box.setAttribute("aria-label", "Guided tour");
    document.querySelector(".gradio-container").append(this.box);
    this.box.onclick = (event) => this.click(/** @type {HTMLElement} */ (event.target));
    this.box.onkeydown = (event) => {
      if (event.key === "Escape") this.end(); // return nothing: false would cancel the Enter key
    };
  }

  screen() {
    return onScreen(this.frames, state.p ?? 0.5, this.facts);
  }

  /** Set the page for a step and show its question. */
  show() {
    const step = STEPS[this.at];
    change({ mode: "", ...step.set });
    const question = typeof step.ask === "function" ? step.ask(this.screen()) : step.ask;
    const options = step.options.map(
      ([key, words]) => `<button type="button" data-option="${key}">${words}</button>`,
    );
    this.lay(step, `<p>${question}</p>`, `<span class="options">${options.join("")}</span>`);
    this.focus("[data-option]");
    const subject = document.querySelector(`.explore ${step.look}`);
    if (subject && !inView(subject, this.box)) subject.scrollIntoView({ block: "start" });
  }

  /** Show the result, and whether the prediction was correct. */
  reveal(option) {
    const step = STEPS[this.at];
    const screen = this.screen();
    const right = [step.right(screen)].flat();
    const words = (key) => step.options.find(([own]) => own === key)[1];
    const verdict = !right.length
      ? ""
      : right.includes(option)
        ? '<b class="right">As you predicted.</b>'
        : `<b class="wrong">Not so. Correct: “${right.map(words).join("”, “")}”.</b>`;
    this.lay(
      step,
      `<p>${verdict} ${step.reveal(screen)}</p>`,
      `<button type="button" class="main next">${this.at + 1 < STEPS.length ? "Next" : "Done"}</button>`,
    );
    this.focus(".next");
  }

  lay(step, text, buttons) {
    this.box.innerHTML = `<div aria-live="polite"><h3>${this.at + 1} of ${STEPS.length} · ${step.title}</h3>${text}</div>
      <div class="row"><button type="button" class="back" ${this.at ? "" : "disabled"}>Back</button>${buttons}<button type="button" class="end" aria-label="End the tour">✕</button></div>`;
  }

  focus(selector) {
    /** @type {HTMLElement} */ (this.box.querySelector(selector)).focus({ preventScroll: true });
  }

  click(target) {
    if (target.dataset.option) return this.reveal(target.dataset.option);
    if (target.matches(".end") || (target.matches(".next") && this.at + 1 === STEPS.length))
      return this.end();
    if (target.matches(".next")) this.at += 1;
    else if (target.matches(".back")) this.at -= 1;
    else return undefined;
    return this.show();
  }

  end() {
    this.box.remove();
    change(this.before);
  }
}
