/** Tint the parts of an image that the prediction depends on. */

import { askOfImage, bytesOf, Refusal, refused } from "../shared/api.js";
import { OTHER } from "../shared/images.js";
import { state } from "../shared/store.js";
import { changed, told, WORTH } from "./hidden-parts.js";
import { taughtBy } from "./taught.js";

const NEEDED = [213, 94, 0]; // hiding it lowers the probability
const AGAINST = [0, 114, 178]; // hiding it raises the probability

/** `own`: the lessons of the head that predicts; {} for the head as trained. */
export async function where(slot, own, onProblem) {
  const { modality } = slot.dataset;
  const what = slot.querySelector(".what");
  const picture = slot.querySelector(".picture");
  const before = what.textContent;
  what.textContent = "Hiding one part after the other…";
  slot.classList.add("busy");
  try {
    const blob = await bytesOf(state[modality], modality);
    if (!blob) throw new Refusal("The server keeps no images. Choose this file again.");
    const other = state[OTHER[modality]];
    const taught = await taughtBy(own);
    const found = await askOfImage("occlusion", blob, { modality, other, order: null, taught });
    picture.querySelector("canvas")?.remove();
    const changes = changed(found.drops);
    picture.classList.toggle("seen", changes.any);
    if (changes.any) picture.append(tint(found, changes.most));
    what.innerHTML = `${taught && '<b class="tag">taught</b> '}${told(found, changes)}`;
  } catch (error) {
    what.textContent = before;
    refused(error, onProblem);
  } finally {
    slot.classList.remove("busy");
  }
}

/** Tint only parts that change the probability. */
function tint({ cells, drops }, most) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = cells;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "Parts of the image that the prediction depends on");
  const image = new ImageData(cells, cells);
  drops.flat().forEach((drop, i) => {
    if (Math.abs(drop) < WORTH) return;
    image.data.set([...(drop > 0 ? NEEDED : AGAINST), Math.round((190 * Math.abs(drop)) / most)], 4 * i);
  });
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}
