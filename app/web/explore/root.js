/** What all parts of Explore use: its elements, its state and the address, markup. */

import { radios } from "../shared/radios.js";
import { change, state, watch } from "../shared/store.js";

export { change, state } from "../shared/store.js";
export { fill, html, percent, put } from "../shared/text.js";
export { scene, take } from "./scene.js";

/** The first part of Explore that fits a selector; Explore itself without one. @type {(selector?: string) => Found} */
export const $ = (selector = "") => document.querySelector(`.ov.explore ${selector}`);

/** All parts that fit a selector. @type {(selector: string) => Found[]} */
export const all = (selector) => [...document.querySelectorAll(`.ov.explore ${selector}`)];

/** What marks the chosen one of some buttons, by their selector. @type {Map<string, () => void>} */
const marks = new Map();
watch(["map", "press", "dots", "known", "reading", "rung"], () => {
  for (const mark of marks.values()) mark();
});

/** Buttons of which one is chosen: a value of the address.
 * @param {string} selector @param {"map" | "press" | "dots" | "known" | "reading" | "rung"} name
 * @param {Parameters<typeof radios>[1]} options */
export function choice(selector, name, options, chosen = () => state[name]) {
  const mark = radios($(selector), options, chosen, (value) => change({ [name]: value }));
  marks.set(selector, mark);
}
