/** Open a tab from elsewhere in the page, and keep it in the address. */

import { change, followHistory, state } from "./store.js";

const AGAIN = 100; // ms

const button = (view) =>
  document.getElementById(`view-${view}-button`) ?? document.querySelector(`[role=tab][aria-controls="view-${view}"]`);

export function openTab(view) {
  button(view)?.click();
}

/** Open the tab of the address. A click before Gradio has laid out its tabs is lost, so check twice. */
function openFirst(view, seen = 0) {
  if (state.view !== view || seen > 1) return; // the visitor chose another tab, or this one stays open
  const open = button(view)?.getAttribute("aria-selected") === "true" && document.getElementById(`view-${view}`);
  if (!open) openTab(view);
  setTimeout(openFirst, AGAIN, view, open ? seen + 1 : 0);
}

export function followTabs() {
  document.addEventListener(
    "click",
    (event) => {
      const target = /** @type {HTMLElement} */ (event.target);
      const id = target.closest?.("[role=tab]")?.id ?? "";
      const view = /^view-(\w+)-button$/.exec(id)?.[1];
      if (!view) return;
      change({ view });
      target.closest("[role=tab]")?.scrollIntoView({ block: "nearest", inline: "center" }); // on a phone, tabs scroll
    },
    true,
  );
  followHistory(openTab);
  if (state.view !== "explore") openFirst(state.view);
}
