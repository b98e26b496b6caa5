/** The guided tour through the chapters. The visitor predicts, then the tour shows the result. */

import { choices, framesOf, twins, twinsMap, unseen } from "../shared/facts.js";
import { verdictOn } from "../shared/gap-words.js";
import { ACCURACY, values } from "../shared/measures.js";
import { setOf } from "../shared/sets.js";
import { OUTPUT } from "../shared/stages.js";
import { change, openChapter, state } from "../shared/store.js";
import { OWN_MODE } from "../shared/tables.js";
import { openTab } from "../shared/tabs.js";
import { html, put } from "../shared/text.js";
import { theSet } from "../shared/theset.js";
import { onClick } from "../shared/view.js";
import { STEPS } from "./steps.js";

/** Start the tour; throws a Refusal if a set or its head cannot be read. */
export async function startTour() {
  if (state.tour >= 0) return;
  const { sets, twins: there } = await choices();
  const [first, second] = ["order", "fooled"].map((chapter) => setOf(chapter, sets));
  const none = () => null;
  const [{ frames: own }, { frames: home }, { modes }, strangers, seen, places] = await Promise.all([
    theSet(() => {}, first),
    theSet(() => {}, setOf("gaps", sets)),
    choices(first),
    unseen(second).catch(none),
    there ? twins().catch(none) : null,
    there ? twinsMap().catch(none) : null,
  ]);
  const frames = modes[0] === OWN_MODE ? own : await framesOf(modes[0], own, first);
  const pale = sets.find(({ name }) => name === "sensors" && first !== second)?.curve?.share;
  const curve = values(frames, ACCURACY, OUTPUT);
  openTab("explore");
  show({ unseen: strangers ?? {}, gaps: verdictOn(home), pale, twins: seen, places, curve, orders: frames.orders });
}

/** Hide the figures of Explore and let its controls rest, or not. @param {HTMLElement} explore @param {boolean} on */
function rest(explore, on) {
  explore.classList.toggle("asking", on);
  /** @type {NodeListOf<HTMLElement>} */
  const parts = explore.querySelectorAll(".chapters, .press, .map-panel, .side > :not(.tour)");
  for (const part of parts) part.inert = on;
}

/** Return what is said of a prediction; nothing if the data cannot decide.
 * @param {TourStep} step @param {string} option @param {Figures} figures */
function verdictOf({ right = () => [], options = [] }, option, figures) {
  const words = right(figures).map((i) => options[i]);
  if (words.includes(option)) return html`<b class="right">Correct.</b> `;
  return words.length ? html`<b class="wrong">No: “${words.join("” or “")}”.</b> ` : null;
}

/** Walk the steps. @param {any} figures as in Figures, those that are there */
function show(figures) {
  const explore = /** @type {HTMLElement} */ (document.querySelector(".explore"));
  const steps = STEPS.filter(({ needs }) => !needs || figures[needs]);
  const { view: _, ...before } = state; // what the visitor left
  const box = document.createElement("div");
  box.className = "ov tour";
  box.setAttribute("role", "dialog");
  box.setAttribute("aria-label", "Guided tour");
  explore.classList.add("touring");
  let opening = new MutationObserver(() => {});

  /** @param {Html} text @param {Html} buttons @param {string} focused */
  const lay = (text, buttons, focused) => {
    put(
      box,
      html`<div aria-live="polite"><h3 tabindex="-1">${state.tour + 1} of ${steps.length} · ${steps[state.tour].title}
        </h3><p>${text}</p></div>
      <div class="row">${buttons}<span class="spring"></span>
        <button class="back"${!state.tour && html` disabled`}>Back</button>
        <button class="end" aria-label="End the tour">✕</button></div>`,
    );
    const focus = () => /** @type {HTMLElement} */ (box.querySelector(focused)).focus({ preventScroll: true });
    const isThere = () => explore.classList.contains("ready"); // what is hidden takes no focus
    opening.disconnect();
    opening = new MutationObserver(() => {
      if (!isThere()) return;
      opening.disconnect();
      focus();
    });
    if (isThere()) focus();
    else opening.observe(explore, { attributeFilter: ["class"] });
  };

  /** Show the result after what is said of the prediction. @param {Html | null} verdict */
  const tell = (verdict) => {
    const { after, reveal } = steps[state.tour];
    rest(explore, false);
    if (after) change(after(figures));
    const button = html`<button class="main next-step">${state.tour + 1 < steps.length ? "Next" : "Done"}</button>`;
    lay(html`${verdict}${reveal(figures)}`, button, ".next-step");
  };

  /** Set the page for a step and show its question; what would answer it is hidden, and rests. @param {number} tour */
  const go = (tour) => {
    if (tour === steps.length) return end();
    change({ tour });
    const { chapter, set, ask, options = [] } = steps[tour];
    openChapter(chapter, set?.(figures));
    explore.querySelector(chapter === "touch" ? ".touch .side" : ".stage .side")?.prepend(box); // in the flow
    if (!ask) return tell(null);
    rest(explore, true);
    const buttons = options.map((words) => html`<button data-option="${words}">${words}</button>`);
    return lay(ask(figures), html`<span class="row">${buttons}</span>`, "h3");
  };

  const end = () => {
    box.remove();
    rest(explore, false);
    explore.classList.remove("touring");
    change({ ...before, tour: -1 });
  };

  onClick(box, {
    "[data-option]": ({ dataset }) => tell(verdictOf(steps[state.tour], dataset.option, figures)),
    ".next-step": () => go(state.tour + 1),
    ".back": () => go(state.tour - 1),
    ".end": end,
  });
  box.onkeydown = ({ key }) => {
    if (key === "Escape") end(); // return nothing: false would cancel the Enter key
  };
  go(0);
}
