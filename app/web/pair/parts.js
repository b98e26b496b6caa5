/** Small pieces of markup that several parts of the tab share, and how a part is drawn. */

import { draw, html } from "../shared/text.js";

/** A button that tells an event, with what its data attributes say.
 * @param {string} event @param {unknown} words @param {Html | string} [attributes] */
export const button = (event, words, attributes = "") =>
  html`<button type="button" data-send="${event}" ${attributes}>${words}</button>`;

/** Whether a button is pressed, as its attribute. @param {unknown} on */
export const pressed = (on) => html`aria-pressed="${String(Boolean(on))}"`;

/** A button that opens pictures. @param {unknown} words @param {Pair} pair @param {Html | string} [more] */
export const opener = (words, pair, more = "") =>
  button("opened", words, html`${Object.entries(pair).map(([name, ref]) => html`data-${name}="${ref}" `)}${more}`);

/** A button that chooses files. @param {string} event @param {string} words @param {Html} kind */
export const chooser = (event, words, kind) =>
  html`<label class="choose">${words}<input type="file" data-send="${event}" ${kind}></label>`;

/** @param {unknown} words */
export const hint = (words) => html`<p class="hint">${words}</p>`;

/** @param {number} n @param {string} one @param {string} [many] */
export const plural = (n, one, many = `${one}s`) => `${n.toLocaleString("en-US")} ${n === 1 ? one : many}`;

/** Draw a part of the tab. Null hides it, undefined leaves it as it is.
 * @param {HTMLElement} box @param {Html | null | undefined} markup */
export function drawPart(box, markup) {
  if (markup === undefined) return;
  box.hidden = !markup;
  draw(box, markup ?? html``);
}
