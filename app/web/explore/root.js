/** What all parts of Explore use: its elements, its state and the address, markup. */

import { radios } from "../shared/radios.js";
import { state } from "../shared/store.js";
import { draw, fill, html } from "../shared/text.js";
import { after, START } from "./state.js";

export { change, state } from "../shared/store.js";
export { draw, fill, grouped, html, interval, joined, options, percent, put } from "../shared/text.js";

/** Explore, which `send` alone replaces. @type {Readonly<Scene>} */
export let scene = START;

/** Send an event; returns Explore after it. @template {keyof SceneEvents} Name
 * @param {Name} name @param {SceneEvents[Name]} detail */
export const send = (name, detail) => (scene = Object.freeze(after(scene, name, detail, state)));

/** The first part of Explore that fits a selector; Explore itself without one. @type {(selector?: string) => Found} */
export const $ = (selector = "") => document.querySelector(`.ov.explore ${selector}`);

/** Return all parts that fit a selector. @type {(selector: string) => Found[]} */
export const all = (selector) => [...document.querySelectorAll(`.ov.explore ${selector}`)];

/** Write the words and figures of a chapter. @param {Words} words */
export function showWords({ title, figure, remark, whence = html`` }) {
  for (const [name, words] of Object.entries({ title: html`${title}`, figure, remark, whence }))
    fill($(`.stage .${name}`), html`${words}`);
}

/** Draw buttons of which one is chosen: a value of the address.
 * @param {string} selector @param {"map" | "mode" | "press" | "dots" | "known" | "reading" | "rung"} name
 * @param {Parameters<typeof radios>[0]} options */
export function choice(selector, name, options, chosen = state[name]) {
  const group = $(selector);
  group.setAttribute("role", "radiogroup");
  draw(group, radios(options, chosen, name));
}
