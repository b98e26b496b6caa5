/** Explore: one picture and one question at a time, drawn in the browser stop by stop. */

import { attempt } from "../shared/api.js";
import { choices } from "../shared/facts.js";
import { openChapter, state } from "../shared/store.js";
import { making, tell } from "../shared/view.js";
import { Page } from "./page.js";

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  const wait = $(".wait");
  const say = (sentence) => {
    tell(wait, sentence, true);
    if (new URLSearchParams(location.search).has("set")) wait.append(" ", homeLink());
  };
  const telling = (step) => tell(wait, step === null ? "" : waiting(step));
  await attempt(async () => {
    const page = new Page($, await choices(), { say, telling });
    if (!state.chapter) openChapter(page.first);
    await page.enter();
  }, say);
}

/** The message for a link to a set that the server no longer has. */
function homeLink() {
  const link = document.createElement("a");
  link.href = location.pathname;
  link.textContent = "Open the page without it.";
  return link;
}

const waiting = (step) =>
  step?.text && !step.total ? `Computing maps: ${step.text}. Pair works meanwhile.` : making(step);
