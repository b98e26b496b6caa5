/** Panels that open and close, and remember it. */

import { keep, keptJson } from "../shared/memory.js";

const KEPT = "omnivat-panels";
const FIRST = { card: true, grid: true, confusion: false }; // open on the first visit

/** `onOpen()` is called after a panel opens. Returns open(name) and show(name). */
export function panels(box, onOpen) {
  const wanted = { ...FIRST, ...keptJson(KEPT, {}) };
  const all = [...box.querySelectorAll("details")];
  const named = (name) => all.find((one) => one.dataset.panel === name);
  for (const one of all) {
    one.open = wanted[one.dataset.panel] ?? false;
    one.ontoggle = () => {
      wanted[one.dataset.panel] = one.open;
      keep(KEPT, JSON.stringify(wanted));
      if (one.open) onOpen();
    };
  }
  return {
    open: (name) => named(name).open && named(name).checkVisibility(),
    show: (name) => {
      named(name).open = true;
    },
  };
}
