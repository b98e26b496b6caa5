/** The page header: title, badge for simulated data, light or dark. */

import { refused } from "../shared/api.js";
import { followTabs } from "../shared/tabs.js";
import { followTheme } from "./theme.js";
import { startTour } from "./tour.js";

export function start(root) {
  followTheme(root.querySelector(".theme"));
  const tour = root.querySelector(".tour-start");
  tour.onclick = () =>
    startTour().catch((error) =>
      refused(error, (sentence) => {
        tour.title = sentence;
        tour.disabled = true;
      }),
    );
  document.addEventListener("omnivat:simulated", (/** @type {CustomEvent} */ event) => {
    root.querySelector(".badge").hidden = !event.detail;
  });
  followTabs();
}
