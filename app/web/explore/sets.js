/** The sets that come with the project, side by side: each opens the page anew on that set. */

import { escaped } from "../shared/text.js";

const WORDS = {
  sensors: "Photos and touches of materials: p hardly matters",
  chirps: "Signals that one p alone tells apart: p is everything",
};

/** Where the page opens on another set: what belongs to the present one stays behind. */
export function addressOf(name, here) {
  const address = new URL(here);
  const kept = new Set(["part", "stage", "gap", "colour", "means"]);
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
