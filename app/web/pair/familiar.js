/** Familiarity of each image, and its nearest training pairs. Text in, HTML out. */

import { thumbnail } from "../shared/card.js";
import { escaped, percent } from "../shared/text.js";

const SIDE = 104; // CSS pixels of a neighbour: large enough to see what it is
const SAME = 0.9999; // the cosine of an image with itself, rounded
const NAMES = { vis: ["photo", "photos"], tac: ["touch", "touch images"] };

/** One sentence on an image, from its quantile among the training images. */
export function sentence(modality, image) {
  const [one, many] = NAMES[modality];
  if (image.words === undefined) return `This head has no record of how familiar a ${one} is.`;
  if (image.cosine > SAME) return `Familiar: it is one of the training ${many}.`;
  const closer = image.quantile < 0.005 ? "all" : percent(1 - image.quantile);
  return `${capital(image.words)}: ${closer} of the training ${many} have a closer neighbour.`;
}

const capital = (text) => text[0].toUpperCase() + text.slice(1);

/** The panel; `set` has thumbnails and names of domains and classes, once loaded. */
export function familiarHtml({ images, of }, set) {
  const rows = Object.entries(images).map(([modality, image]) => {
    const mark = image.guess ? "wrong" : image.words === "unusual" ? "unusual" : "right";
    const meter =
      image.quantile === undefined
        ? ""
        : `<div class="meter" aria-hidden="true"><i class="${mark}" style="--at:${image.quantile}"></i></div>`;
    return `<div class="look" data-modality="${modality}"><h4><span class="sign ${modality}"></span>${capital(NAMES[modality][0])}</h4>
      <p class="${image.words === undefined ? "hint" : mark}">${escaped(sentence(modality, image))}</p>${meter}
      <div class="nearest">${image.nearest.map((one) => neighbour(one, modality, set)).join("")}</div></div>`;
  });
  return `<header><h3>Has it seen anything like this?</h3><p class="hint">Nearest in the encoder’s space among ${escaped(of)}.</p></header><div class="looked">${rows.join("")}</div>`;
}

function neighbour({ pair, cosine }, modality, { frames, sprite }) {
  const tile = frames ? pair + (modality === "tac" ? frames.pairs : 0) : pair;
  const name = frames ? frames.classes[frames.label[pair]] : "";
  const where = frames ? frames.domains[frames.domain[pair]] : "";
  const picture = frames ? thumbnail(sprite, tile, SIDE, `${NAMES[modality][0]} of ${name}`) : "";
  return `<button type="button" data-pair="${pair}" title="Open this pair">${picture}<small><b>${escaped(name || `pair ${pair}`)}</b> ${cosine.toFixed(2)}<br>${escaped(where)}</small></button>`;
}
