/** The panels beside the map, which stay open or closed between visits, and the link to another set. */

import { keep, keptJson } from "../shared/memory.js";
import { $, all } from "./root.js";

const KEPT = "omnivat-panels";
const FIRST = { card: true }; // open on the first visit

/** @param {string} name */
const panel = (name) => $(`[data-panel="${name}"]`);
/** @param {string} name */
export const panelIsOpen = (name) => panel(name).open && panel(name).checkVisibility();

/** @param {string} name */
export function openPanel(name) {
  panel(name).open = true;
  panel(name).scrollIntoView({ block: "start" });
}

/** Open the panels that were open. @param {() => void} onOpen called after a panel opens */
export function rememberPanels(onOpen) {
  const wanted = { ...FIRST, ...keptJson(KEPT, {}) };
  for (const panel of all(".panels details")) {
    const name = panel.dataset.panel;
    panel.open ||= wanted[name] ?? false; // a visitor may have opened it already
    panel.ontoggle = () => {
      wanted[name] = panel.open;
      keep(KEPT, JSON.stringify(wanted));
      if (!panel.open) return;
      onOpen();
      if (panel.contains(document.activeElement)) panel.scrollIntoView({ block: "nearest" });
    };
  }
}

/** Return the address of the page on another set, without the state of the current one.
 * @param {string} name
 * @param {string} here */
export function addressOf(name, here) {
  const address = new URL(here);
  const kept = new Set(["chapter", "stage", "colour", "means"]);
  for (const key of [...address.searchParams.keys()]) if (!kept.has(key)) address.searchParams.delete(key);
  address.searchParams.set("set", name);
  return address.href;
}
