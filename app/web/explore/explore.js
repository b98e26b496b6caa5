/** Explore: one slider for the whole set, drawn in the browser stop by stop. */

import { refused } from "../shared/api.js";
import { choices } from "../shared/facts.js";
import { whenFine } from "../shared/frames.js";
import { theSet } from "../shared/theset.js";
import { openingMode } from "./modes.js";
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
    wait.textContent = waiting(step);
  };
  try {
    const [{ frames, coarse, sprite }, choice] = await Promise.all([theSet(telling), choices()]);
    const page = new Page($, frames, sprite, choice, say);
    await page.open(openingMode(choice.modes));
    wait.hidden = !wait.classList.contains("problem");
    $(".explore").classList.add("ready");
    if (!coarse) return;
    wait.hidden = false;
    page.finer(await whenFine(telling));
    wait.hidden = true;
  } catch (error) {
    refused(error, say);
  }
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
