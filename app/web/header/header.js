/** The page header: title, badge for simulated data, light or dark. */

import { attempt } from "../shared/api.js";
import { limits } from "../shared/limits.js";
import { keep, kept } from "../shared/memory.js";
import { followArrows } from "../shared/radios.js";
import { followTabs } from "../shared/tabs.js";
import { showDefinitions } from "../shared/terms.js";
import { startTour } from "./tour.js";

/** Start the header: theme, tour, and the badge of simulated data. @param {Found} root */
export function start(root) {
  followTheme(root.querySelector(".theme"));
  const tour = root.querySelector(".tour-start");
  tour.onclick = () =>
    attempt(startTour, (/** @type {string} */ sentence) => {
      tour.title = sentence;
      tour.disabled = true;
    });
  const badge = root.querySelector(".badge");
  const simulated = [...badge.childNodes];
  document.addEventListener("omnivat:simulated", (event) => {
    badge.hidden = false;
    badge.replaceChildren(...(event instanceof CustomEvent && !event.detail ? ["real pairs"] : simulated));
  });
  document.addEventListener("omnivat:lost", (event) => {
    root.querySelector(".lost").hidden = !(event instanceof CustomEvent && event.detail);
  });
  limits(root.querySelector(".limits"));
  followArrows();
  showDefinitions();
  followTabs();
}

export const THEME = "omnivat-theme"; // key of the chosen one in the browser

/** Let the button switch between light and dark; printed pages are light. @param {HTMLElement} button */
function followTheme(button) {
  const chosen = kept(THEME);
  if (chosen) document.body.classList.toggle("dark", chosen === "dark");
  let dark = false;
  const onPaper = () => {
    dark = document.body.classList.contains("dark");
    document.body.classList.remove("dark");
  };
  addEventListener("beforeprint", onPaper, { capture: true }); // before the maps draw
  addEventListener("afterprint", () => document.body.classList.toggle("dark", dark));
  button.onclick = () => keep(THEME, document.body.classList.toggle("dark") ? "dark" : "light");
}
