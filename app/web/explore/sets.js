/** The sets of the project; each button opens the page on that set. */

import { escaped } from "../shared/text.js";

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
  box.innerHTML = sets
    .map(
      ({ name, title, shown }) =>
        `<button type="button" data-set="${escaped(name)}" aria-pressed="${shown}" title="${escaped(WORDS[name] ?? "")}">${escaped(title)}</button>`,
    )
    .join("");
  box.onclick = (event) => {
    const button = event.target.closest("[data-set]");
    if (button && button.getAttribute("aria-pressed") !== "true")
      location.assign(addressOf(button.dataset.set, location.href));
  };
}
