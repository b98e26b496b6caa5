/** The page without a server: plain tabs; the script of a tab is fetched when the tab first opens. */

import { start as startHeader } from "../header/header.js";
import { held, line } from "../shared/held.js";
import { state } from "../shared/store.js";

const tabs = /** @type {HTMLElement[]} */ ([...document.querySelectorAll("[role=tab]")]);
const started = new Set();

/** Show one tab, and start it if it was never open. @param {string} view */
async function open(view) {
  for (const tab of tabs) {
    const chosen = tab.id === `view-${view}-button`;
    tab.setAttribute("aria-selected", String(chosen));
    tab.tabIndex = chosen ? 0 : -1;
    document.getElementById(tab.getAttribute("aria-controls") ?? "")?.toggleAttribute("hidden", !chosen);
  }
  const panel = document.getElementById(`view-${view}`);
  if (started.has(view) || !panel?.querySelector("section")) return; // a tab without a script is one sentence
  started.add(view);
  if (view === "pair" && held?.local) {
    const coming = import("./local.js").then(({ prepare }) => prepare()).catch(() => {});
    document.body.classList.add("fetching");
    line.models = coming.then(() => document.body.classList.remove("fetching"));
  }
  const { start } = await import(`../${view}/${view}.js`);
  await start(panel);
}

/** With a network, fetch the rest once the first view is there, so that the next visit needs none. */
async function keep() {
  await line.models;
  await navigator.serviceWorker.register("sw.js");
  const { active } = await navigator.serviceWorker.ready;
  if (!(/** @type {any} */ (navigator).connection?.saveData)) active?.postMessage("keep");
}

for (const tab of tabs) tab.onclick = () => open(tab.id.split("-")[1]);
document.body.classList.toggle("dark", matchMedia("(prefers-color-scheme: dark)").matches);
document.querySelector(".unstarted")?.remove();
startHeader(document.querySelector("#omnivat-header"));
await open(state.view);
// a browser may forbid it; the page works without
if (navigator.serviceWorker) setTimeout(() => keep().catch(() => {}), 2000);
