/** Starts header and Explore in the page as it is sent. Gradio, which takes longer, takes both to their places. */

import { start as startHeader, THEME } from "../header/header.js";
import { kept } from "../shared/memory.js";
import { awaited } from "../shared/ready.js";
import { state } from "../shared/store.js";
import { nameDocument } from "../shared/tabs.js";
import { start } from "./explore.js";
import { bringIntoSight } from "./page.js";

const shell = /** @type {HTMLElement} */ (document.getElementById("omnivat-first"));
const header = /** @type {HTMLElement} */ (shell.querySelector(".top"));
const explore = /** @type {HTMLElement} */ (shell.querySelector(".explore"));
function themed() {
  const theme = kept(THEME) ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  const { classList } = document.body;
  if (classList.contains("dark") !== (theme === "dark")) classList.toggle("dark");
}
themed();
const watcher = new MutationObserver(themed); // Gradio sets its own when it starts
watcher.observe(document.body, { attributeFilter: ["class"] });
explore.hidden = state.view !== "explore";

/** @type {() => void} */
let moved = () => {};
awaited(new Promise((done) => (moved = () => done(null))));
startHeader(header);
start();

const ENDS = ["pointerup", "pointercancel"];
let pressed = false;
for (const kind of ["pointerdown", ...ENDS])
  addEventListener(kind, () => (pressed = kind === "pointerdown"), { capture: true });

/** @type {Map<Element, HTMLElement>} */
const places = new Map();

/** Tell where Gradio has the part `name`; both parts move there together, with what is focused or open in them.
 * @param {"header" | "explore"} name @param {HTMLElement} place */
export function adopt(name, place) {
  places.set({ header, explore }[name], place);
  if (places.size < 2) return;
  if (pressed)
    for (const end of ENDS) addEventListener(end, () => setTimeout(move), { once: true }); // after the click
  else move();
}

/** Move both parts to their places, not while a drag goes on, which would end. */
function move() {
  if (!shell.isConnected) return;
  const focused = /** @type {HTMLElement | null} */ (document.activeElement);
  const opened = /** @type {NodeListOf<HTMLElement>} */ (shell.querySelectorAll(":popover-open"));
  for (const [part, at] of places) at.append(part);
  for (const popover of opened) popover.showPopover();
  focused?.focus({ preventScroll: true });
  explore.hidden = false;
  bringIntoSight(); // an element that moves is no longer scrolled
  shell.remove();
  watcher.disconnect();
  nameDocument();
  moved();
}
