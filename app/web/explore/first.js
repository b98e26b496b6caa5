/** Starts Explore in the page as it is sent. Gradio, which takes longer, finds it there and takes it into its tab. */

import { kept } from "../shared/memory.js";
import { awaited } from "../shared/ready.js";
import { state } from "../shared/store.js";
import { start } from "./explore.js";

const shell = /** @type {HTMLElement} */ (document.getElementById("omnivat-first"));
const explore = /** @type {HTMLElement} */ (shell.querySelector(".explore"));
const theme = kept("omnivat-theme") ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
document.body.classList.toggle("dark", theme === "dark");
explore.hidden = state.view !== "explore";

/** @type {() => void} */
let moved = () => {};
awaited(new Promise((done) => (moved = () => done(null))));
start();

/** Move Explore into its tab, with what is focused in it. @param {HTMLElement} tab */
export function adopt(tab) {
  const focused = /** @type {HTMLElement | null} */ (document.activeElement);
  tab.append(explore);
  focused?.focus({ preventScroll: true });
  explore.hidden = false;
  shell.remove();
  moved();
}
