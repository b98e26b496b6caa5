/** Where a pair is chosen: two image slots (file, drop, paste, camera), and the shelf of examples. */

import { address } from "../shared/api.js";
import { thumbnail } from "../shared/card.js";
import { shelf } from "../shared/pick.js";
import { sensorOf } from "../shared/tables.js";
import { describe, partsOf } from "./own-pictures.js";
import { button, chooser, hint, html, IMAGES, OTHER, opener, pressed, signed, TERMS } from "./parts.js";
import { changed, outcome } from "./where.js";

/** The picture of an example. @param {string} name @param {Modality} modality */
const exampleOf = (name, modality) =>
  address(`example/${name.split("/").map(encodeURIComponent).join("/")}/${modality}`);

/** The thumbnail of a pair of the set. @param {PairSet} set @param {number} pair @param {Modality} modality
 * @param {number} side @param {string} words */
export const tileOf = ({ frames, sprite }, pair, modality, side, words) =>
  frames && pair < frames.pairs && thumbnail(sprite, pair + (modality === "tac" ? frames.pairs : 0), side, words);

/** Both slots. @param {PairTab} tab */
export const slotsHtml = (tab) => html`${IMAGES.map((modality) => slotHtml(tab, modality))}`;

/** @param {PairTab} tab @param {Modality} modality */
function slotHtml(tab, modality) {
  const { title, one } = TERMS[modality];
  const { [modality]: ref, [OTHER[modality]]: other } = tab;
  const doing = tab.doing[modality];
  const parts = tab.explained[modality];
  const of = html`data-modality="${modality}"`;
  const choose = html`multiple ${of} accept="image/*,.tif,.tiff,.webp,.png,.jpg" aria-label="Choose a ${one}"`;
  const why = html`class="where" ${of} title="Hide one part of the image after the other and show how the prediction
    changes"${(!ref || ref.startsWith("row:")) && " disabled"}`;
  const away = html`class="clear" aria-label="Remove the ${one}"${!ref && " disabled"}`;
  const empty = other ? "Empty. The prediction uses the other image only." : "Empty.";
  return html`<div class="slot panel ${doing && "busy"}" ${of} tabindex="0"
    aria-label="${title}: ${modality.toUpperCase()}. Drop or paste an image here.">
    <h3>${signed(modality, title)}</h3>${tab.filming === modality ? FILM : pictureHtml(tab, modality)}
    <div class="row">${chooser("dropped", "Choose file", choose)}
      ${button("photograph", "Camera", html`class="camera" ${of} title="Take one picture with a camera"`)}
      ${button("explain", "Where?", why)}${opener("Remove", { [modality]: "" }, away)}</div>
    <p class="what hint">${doing || (parts ? outcome(parts) : ref ? describe(tab, ref).text : empty)}</p>
  </div>`;
}

const FILM = html`<div class="picture filming"><video autoplay playsinline muted></video>
  <div class="row"><button class="main">Take it</button><button>Cancel</button></div></div>`;

/** @param {PairTab} tab @param {Modality} modality */
function pictureHtml({ set, explained, sent, mend, ...tab }, modality) {
  const { title } = TERMS[modality];
  const ref = tab[modality] ?? "";
  const [kind, name] = partsOf(ref);
  const image = sent[ref];
  const example = kind === "example" && { src: exampleOf(name, modality), alt: `${title} of ${name}` };
  const { src, alt } = example || { src: image?.src, alt: `${title}: ${image?.name}` };
  const none = html`<span>${ref ? "This picture was sent earlier" : "Drop or paste an image"}</span>`;
  const shown = src
    ? html`<img src="${src}" alt="${alt}">`
    : kind === "row" && tileOf(set, +name, modality, 150, title);
  const parts = explained[modality];
  const any = parts && changed(parts.drops).any;
  const tint = any && html`<canvas role="img" aria-label="Parts of the image that the prediction depends on"></canvas>`;
  const way = modality === "tac" && kind === "image" && mend;
  return html`<div class="picture ${any && "seen"} ${way}">${shown || none}${tint}</div>`;
}

/** The shelf. @param {PairTab} tab */
export function galleryHtml({ examples, set, take, vis, tac }) {
  const offers = shelf(examples, set.frames);
  if (!offers.length && set.gone) return null; // no map is being computed
  const none = set.frames
    ? "This set has no examples. Upload images, or pin a pair in Explore."
    : "The examples appear with the map, which is being drawn. Your own images can be used meanwhile.";
  return html`${offers.map(({ ref, truth, domain, path = "", pair: row }) => {
    const name = `${truth}, ${sensorOf(domain)}`;
    const pictures = IMAGES.map((modality) =>
      row === undefined ? pictured(exampleOf(path, modality)) : tileOf(set, row, modality, 48, TERMS[modality].one),
    );
    return opener(
      framed(pictures, truth),
      take === "both" ? { vis: ref, tac: ref } : { [take]: ref },
      html`title="${name}" aria-label="${name}" ${pressed([vis, tac].includes(ref))}`,
    );
  })}${!offers.length && hint(none)}`;
}

/** A picture of a pair on a shelf. @param {string} src */
export const pictured = (src) => html`<img loading="lazy" alt="" src="${src}">`;
/** A pair on a shelf. @param {unknown} pictures @param {string} words */
export const framed = (pictures, words) => html`<span>${pictures}</span><small>${words}</small>`;
