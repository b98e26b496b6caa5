/** Explore: one picture and one question at a time, drawn in the browser stop by stop. */

import { attempt } from "../shared/api.js";
import { choices } from "../shared/facts.js";
import { openChapter, state } from "../shared/store.js";
import { Page } from "./page.js";

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  const wait = $(".wait");
  const say = (sentence) => {
    wait.hidden = false;
    wait.classList.add("problem");
    wait.textContent = sentence;
    if (new URLSearchParams(location.search).has("set")) wait.append(" ", homeLink());
  };
  const telling = (step) => {
    wait.hidden = step === null;
    wait.textContent = waiting(step);
  };
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

function waiting(step) {
  if (!step) return "Computing maps…";
  const share = step.total ? `, ${step.done} of ${step.total}` : step.text ? `: ${step.text}` : "";
  return `Computing maps${share}. Pair works meanwhile.`;
}
