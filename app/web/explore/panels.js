/** The panels beside the map, which open and close and remember it, and the buttons of the project’s sets. */

import { keep, keptJson } from "../shared/memory.js";
import { each, escaped } from "../shared/text.js";
import { onClick } from "../shared/view.js";

const KEPT = "omnivat-panels";
const FIRST = { card: true }; // open on the first visit

/** `onOpen()` is called after a panel opens. Returns open(name) and show(name). */
export function panels(box, onOpen) {
  const wanted = { ...FIRST, ...keptJson(KEPT, {}) };
  const all = [...box.querySelectorAll("details")];
  const named = (name) => all.find((one) => one.dataset.panel === name);
  for (const one of all) {
    one.open ||= wanted[one.dataset.panel] ?? false; // a visitor may have opened it already
    one.ontoggle = () => {
      wanted[one.dataset.panel] = one.open;
      keep(KEPT, JSON.stringify(wanted));
      if (!one.open) return;
      onOpen();
      if (one.contains(document.activeElement)) one.scrollIntoView({ block: "nearest" });
    };
  }
  return {
    open: (name) => named(name).open && named(name).checkVisibility(),
    show: (name) => {
      named(name).open = true;
      named(name).scrollIntoView({ block: "start" });
    },
  };
}

const WORDS = {
  sensors: "Photos and touches of materials: p hardly matters",
  chirps: "Signals that only one p tells apart: p is everything",
};

/** The address of the page on another set, without the state of the current one. */
export function addressOf(name, here) {
  const address = new URL(here);
  const kept = new Set(["chapter", "stage", "colour", "means"]);
  for (const key of [...address.searchParams.keys()]) if (!kept.has(key)) address.searchParams.delete(key);
  address.searchParams.set("set", name);
  return address.href;
}

export function showSets(box, sets) {
  box.hidden = sets.length < 2;
  box.innerHTML = each(
    sets,
    ({ name, title, shown }) =>
      `<button type="button" data-set="${escaped(name)}" aria-pressed="${shown}" title="${escaped(WORDS[name] ?? "")}">${escaped(title)}</button>`,
  );
  onClick(box, { "[aria-pressed=false]": ({ dataset }) => location.assign(addressOf(dataset.set, location.href)) });
}
