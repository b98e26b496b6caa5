/** What all parts of Try a pair use: the words for images and readings, small pieces of markup, and how a part is
 * drawn. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { draw, grouped, html } from "../shared/text.js";

export { IMAGES, imagesOf, OTHER, READINGS } from "../shared/images.js";
export { draw, fill, html, NO_CLASS, options, percent, put, row, table } from "../shared/text.js";

/** The two images of a pair, in words. @type {Record<Modality, {title: string, one: string, many: string}>} */
export const TERMS = {
  vis: { title: "Photo", one: "photo", many: "photos" },
  tac: { title: "Touch", one: "touch", many: "touches" },
};
/** What was read, in a sentence on counts. @param {Reading} reading */
export const readFrom = (reading) => (reading === "fused" ? "with both images" : `with the ${TERMS[reading].one} only`);
/** @param {Reading} reading */
export const titleOf = (reading) => (reading === "fused" ? "Both" : `${TERMS[reading].title} only`);
/** Words with the sign of a reading, which is that of its image; its title if there are none.
 * @param {Reading} reading */
export const signed = (reading, words = titleOf(reading)) => html`<span class="sign ${reading}"></span>${words}`;

/** @param {string} text */
export const capital = (text) => text[0].toUpperCase() + text.slice(1);

/** In a set of signals, a pair is two recordings of one signal: no photo and no touch. */
export function speakOfSignals() {
  ["first", "second"].forEach((which, i) =>
    Object.assign(TERMS[IMAGES[i]], { title: capital(which), one: `${which} recording`, many: `${which} recordings` }),
  );
}

/** How own touches are mended before they are read, by the word of a request. @type {Record<string, string>} */
export const MENDS = {
  "left-right": "mirrored from left to right",
  "top-bottom": "mirrored from top to bottom",
  "half-turn": "turned by 180°",
  clockwise: "turned clockwise",
  anticlockwise: "turned anticlockwise",
  bgr: "with red and blue swapped",
  fill: "with their dots filled",
};
/** @param {string} mend */
export const mendedBy = (mend) =>
  mend
    .split(" ")
    .map((word) => MENDS[word])
    .join(" and ");

/** What a profile was made of, in words. @param {NonNullable<PairTab["counts"]>} counts */
export const madeOf = (counts) =>
  imagesOf(counts)
    .map((name) => plural(counts[name] ?? 0, TERMS[name].one, TERMS[name].many))
    .join(" and ");

/** A button that sends an event, with its data attributes as values.
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

/** Words of a kind, on lines of their own. @param {string} kind @param {...unknown} words */
export const paragraph = (kind, ...words) => html`<p class="${kind}">${words}</p>`;
/** @param {unknown} words */
export const hint = (words) => paragraph("hint", words);
/** Words that change while they are read, also by screen readers. @param {unknown} words */
export const status = (words, kind = "") => html`<p class="hint ${kind}" role="status">${words}</p>`;

/** A heading with elements beside it. @param {string} title @param {...unknown} beside */
export const headed = (title, ...beside) => html`<header><h3>${title}</h3>${beside}</header>`;
/** Content that opens below its name. @param {string} name @param {...unknown} content */
export const folded = (name, ...content) => html`<details><summary>${name}</summary>${content}</details>`;

/** What pictures can be, to choose from. @param {string} event */
export const kinds = (event) => IMAGES.map((kind) => button(event, TERMS[kind].many, html`data-kind="${kind}"`));

/** @param {number} n @param {string} one @param {string} [many] */
export const plural = (n, one, many = `${one}s`) => `${grouped(n)} ${n === 1 ? one : many}`;

/** Draw a part of the tab. Null hides it, undefined leaves it as it is.
 * @param {HTMLElement} box @param {Html | null | undefined} markup */
export function drawPart(box, markup) {
  if (markup === undefined) return;
  box.hidden = !markup;
  draw(box, markup ?? html``);
}

export const LARGEST = 20e6; // bytes of the files of one request; a single one may be above

/** Parts of a list, of at most so many items, and whose sizes are at most LARGEST.
 * @template Item @param {Item[]} items @param {number} most @param {(item: Item) => number} size */
export function batches(items, most, size) {
  /** @type {Item[][]} */
  const parts = [];
  let left = 0;
  for (const item of items) {
    const last = parts.at(-1);
    left -= size(item);
    if (last && last.length < most && left >= 0) last.push(item);
    else {
      parts.push([item]);
      left = LARGEST - size(item);
    }
  }
  return parts;
}
