/** The head of the page: what this is, whether its data are simulated, light or dark. */

import { refused } from "./api.js";
import { followTabs } from "./tabs.js";
import { startTour } from "./tour.js";

export function start(root) {
  root.querySelector(".theme").onclick = () => document.body.classList.toggle("dark");
  root.querySelector(".tour-start").onclick = () => startTour().catch((error) => refused(error, () => {}));
  document.addEventListener("omnivat:simulated", (event) => {
    root.querySelector(".badge").hidden = !event.detail;
  });
  followTabs();
}
