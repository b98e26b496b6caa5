/** Open a tab from elsewhere in the page, and keep it in the address. */

import { change, followHistory, state, watch } from "./store.js";
import { joined } from "./text.js";

const AGAIN = 100; // ms

/** @param {string} view @returns {HTMLElement | null} */
const button = (view) =>
  document.getElementById(`view-${view}-button`) ?? document.querySelector(`[role=tab][aria-controls="view-${view}"]`);

/** @param {string} view */
export function openTab(view) {
  button(view)?.click();
}

/** Open the tab of the address. A click before Gradio has laid out its tabs is lost, so check twice.
 * @param {string} view */
function openFirst(view, seen = 0) {
  if (state.view !== view || seen > 1) return; // the visitor chose another tab, or this one stays open
  const open = button(view)?.getAttribute("aria-selected") === "true" && document.getElementById(`view-${view}`);
  if (!open) openTab(view);
  setTimeout(openFirst, AGAIN, view, open ? seen + 1 : 0);
}

/** Give the document the name of the open chapter or tab. */
export function nameDocument() {
  const { view, chapter } = state;
  const named = document.querySelector(
    view === "explore" ? `.chapters [data-chapter="${chapter}"]` : `#view-${view}-button`,
  );
  document.title = joined([named?.textContent?.trim(), "OmniVaT"], " · ");
}

/** Keep the open tab in the address, and open the tab that the address names. */
export function followTabs() {
  const followed = (/** @type {Found} */ { target }) => {
    const tab = target.closest?.("[role=tab]");
    const view = /^view-(\w+)-button$/.exec(tab?.id)?.[1];
    if (!view) return;
    change({ view });
    tab.scrollIntoView({ block: "nearest", inline: "center" }); // on a phone, tabs scroll
  };
  document.addEventListener("click", followed, true);
  followHistory(openTab);
  watch(["view", "chapter"], nameDocument);
  nameDocument();
  if (state.view !== "explore") openFirst(state.view);
}
