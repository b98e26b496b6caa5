/** Explore: one picture and one question at a time, drawn in the browser stop by stop. */

import { attempt } from "../shared/api.js";
import { choices } from "../shared/facts.js";
import { openChapter } from "../shared/store.js";
import { enter, say } from "./page.js";
import { $, html, put, send, state } from "./root.js";
import { wire } from "./wiring.js";

const WORDS = /** @type {Record<string, string>} */ ({
  sensors: "Photos and touches of materials; p hardly changes accuracy",
  chirps: "Signals that separate at only one value of p",
});

/** Start Explore: fetch the choices, and open the chapter in the address or the first that the set has. */
export async function start() {
  await attempt(async () => {
    const { sets, twins } = await choices();
    const own = !sets.some(({ shown }) => shown);
    const first = own ? "analyse" : twins ? "touch" : "order";
    send("arrived", { sets, first });
    showSets(sets);
    for (const name of ["touch", "where"]) $(`.chapters [data-chapter=${name}]`).hidden = !twins; // as in a saved page
    if (!state.chapter) openChapter(first);
    wire();
    await enter();
  }, say);
}

/** Show the buttons of the project’s sets. @param {SetRow[]} sets */
function showSets(sets) {
  $(".sets").hidden = sets.length < 2;
  put(
    $(".sets"),
    html`${sets.map(
      ({ name, title, shown }) =>
        html`<button data-set="${name}" aria-pressed="${String(shown)}" title="${WORDS[name] ?? ""}">${title}</button>`,
    )}`,
  );
}
