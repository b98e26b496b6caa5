/** Open a tab from elsewhere in the page, and keep the open one in the address. */

import { change, state } from "./store.js";

const button = (view) => document.getElementById(`view-${view}-button`)
  ?? document.querySelector(`[role=tab][aria-controls="view-${view}"]`);

export function openTab(view) {
  button(view)?.click();
}

export function followTabs() {
  document.addEventListener("click", (event) => {
    const id = event.target.closest?.("[role=tab]")?.id ?? "";
    const view = /^view-(\w+)-button$/.exec(id)?.[1];
    if (view) change({ view });
  }, true);
  if (state.view !== "explore") openTab(state.view);
}
