/** The head of the page: what this is, whether its data are simulated, light or dark. */

import { followTabs } from "./tabs.js";

export function start(root) {
  root.querySelector(".theme").onclick = () => document.body.classList.toggle("dark");
  document.addEventListener("omnivat:simulated", (event) => {
    root.querySelector(".badge").hidden = !event.detail;
  });
  followTabs();
}
