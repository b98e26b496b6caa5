/** Familiarity of each image, and its nearest training pairs. Text in, HTML out. */

import { thumbnail } from "../shared/card.js";
import { OTHER } from "../shared/images.js";
import { escaped, NO_CLASS } from "../shared/text.js";
import { TERMS } from "./verdict.js";

const SIDE = 104; // CSS pixels of a neighbour: large enough to see what it is
const SAME = 0.9999; // the cosine of an image with itself, rounded

/** One sentence on an image, from its quantile among the training images. */
export function sentence(modality, image) {
  const { one, many } = TERMS[modality];
  if (image.words === undefined) return `This head has no record of how familiar a ${one} is.`;
  if (image.cosine > SAME) return `Familiar: it is one of the training ${many}.`;
  const farther = Math.round(100 * image.quantile);
  const count = farther < 1 ? "fewer than 1" : farther > 99 ? "more than 99" : farther;
  return `${capital(image.words)}: ${count} of 100 training ${many} ${count === 1 ? "has" : "have"} a farther neighbour.`;
}

const capital = (text) => text[0].toUpperCase() + text.slice(1);

/** A question about pictures that are nearer to the training images of the other slot; "" if none is. */
export function swapHtml(images) {
  const all = Object.entries(images);
  if (!all.length || !all.every(([, image]) => image.strays)) return "";
  const [[modality]] = all;
  const said =
    all.length > 1
      ? `Are these two swapped? The ${TERMS.vis.one} is nearer to the training ${TERMS.tac.many}, the ${TERMS.tac.one} to the ${TERMS.vis.many}.`
      : `Is this a ${TERMS[OTHER[modality]].one}? It is nearer to those than to the training ${TERMS[modality].many}.`;
  return `<p class="note swapped">${said} <button type="button" class="swap">${all.length > 1 ? "Swap them" : "Move it"}</button></p>`;
}

/** The panel; `set` has thumbnails and names of domains and classes, once loaded. */
export function familiarHtml({ images, of }, set) {
  const rows = Object.entries(images).map(([modality, image]) => {
    const mark = image.guess ? "wrong" : "right";
    const meter =
      image.quantile === undefined
        ? ""
        : `<div class="meter" aria-hidden="true"><i class="${mark}" style="--at:${image.quantile}"></i></div>`;
    return `<div class="look" data-modality="${modality}"><h4><span class="sign ${modality}"></span>${capital(TERMS[modality].one)}</h4>
      <p class="${image.words === undefined ? "hint" : mark}">${escaped(sentence(modality, image))}</p>${meter}
      <div class="nearest">${image.nearest.map((one) => neighbour(one, modality, set)).join("")}</div></div>`;
  });
  return `<header><h3>Seen before?</h3><p class="hint">Nearest: ${escaped(of)}</p></header><div class="looked">${rows.join("")}</div>`;
}

function neighbour({ pair, cosine }, modality, { frames, sprite }) {
  const tile = frames ? pair + (modality === "tac" ? frames.pairs : 0) : pair;
  const label = frames ? frames.classes[frames.label[pair]] : "";
  const name = label === NO_CLASS ? "" : label;
  const where = frames ? frames.domains[frames.domain[pair]] : "";
  const picture = frames
    ? thumbnail(sprite, tile, SIDE, name ? `${TERMS[modality].one} of ${name}` : TERMS[modality].one)
    : "";
  return `<button type="button" data-pair="${pair}" title="Open this pair${where && ` of ${escaped(where)}`}">${picture}<small><b>${escaped(name || `pair ${pair}`)}</b> ${cosine.toFixed(2)}</small></button>`;
}
