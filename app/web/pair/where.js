/** Which parts of an image the prediction depends on: a tint, and words. */

import { paintCells } from "../shared/canvas.js";
import { html, percent } from "./parts.js";

/** @type {Rgb} */
const NEEDED = [213, 94, 0]; // hiding it lowers the probability
/** @type {Rgb} */
const AGAINST = [0, 114, 178]; // hiding it raises the probability
const WORTH = 0.02; // smaller changes of the probability are not shown

/** Tint only parts that change the probability. @param {HTMLCanvasElement} canvas @param {Parts} parts */
export function tint(canvas, { drops }) {
  const { most } = changed(drops);
  paintCells(canvas, drops.length, drops.length, (x, y) => {
    const drop = drops[y][x];
    const strength = Math.abs(drop) < WORTH ? 0 : Math.round((190 * Math.abs(drop)) / most);
    return [...(drop > 0 ? NEEDED : AGAINST), strength];
  });
}

/** The largest change of the probability when a part is hidden, and whether to show it. @param {number[][]} drops */
export function changed(drops) {
  const all = drops.flat();
  const most = Math.max(...all.map(Math.abs));
  return { most, any: most >= WORTH, needed: Math.max(...all) >= WORTH, against: Math.min(...all) <= -WORTH };
}

/** The result, in words; without the probability of its class, as the image may be unlike anything seen.
 * @param {Pick<Parts, "class" | "drops" | "taught">} parts */
export function outcome({ class: name, drops, taught }) {
  const { most, any, needed, against } = changed(drops);
  const parts = [
    needed && html`orange parts support <i>${name}</i>`,
    needed && against && "; ",
    against && "blue parts contradict it",
  ];
  const words = any
    ? html`: ${parts}. Hiding a part changes its probability by at most ${percent(most)}.`
    : html`: no single part matters. Hiding any part changes its probability by less
        than${" "}${percent(Math.max(most, 0.001), 1)}.`;
  return html`${taught && html`<b class="tag">taught</b> `}<b>${name}</b>${words}`;
}
