/** Tint the parts of an image that the prediction depends on. */

import { askOfImage, bytesOf, Refusal, readerOf, refused } from "../shared/api.js";
import { paintCells } from "../shared/canvas.js";
import { OTHER } from "../shared/images.js";
import { state } from "../shared/store.js";
import { escaped, percent } from "../shared/text.js";
import { taughtBy } from "./tally.js";

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
    const found = await askOfImage("occlusion", blob, { modality, other, order: null, taught, head: readerOf(state) });
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
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "Parts of the image that the prediction depends on");
  paintCells(canvas, cells, cells, (x, y) => {
    const drop = drops[y][x];
    const strength = Math.abs(drop) < WORTH ? 0 : Math.round((190 * Math.abs(drop)) / most);
    return [...(drop > 0 ? NEEDED : AGAINST), strength];
  });
  return canvas;
}

export const WORTH = 0.02; // smaller changes of the probability are not shown

/** The largest change of the probability when a part is hidden, and whether to show it. */
export function changed(drops) {
  const all = drops.flat();
  const most = Math.max(...all.map(Math.abs));
  return { most, any: most >= WORTH, needed: Math.max(...all) >= WORTH, against: Math.min(...all) <= -WORTH };
}

/** The result, in words. */
export function told(found, { most, any, needed, against }) {
  const said = `<b>${escaped(found.class)}</b>`; // without its probability: the image may be unlike anything seen
  if (!any)
    return `${said}: no single part matters. Hiding any part changes its probability by less than ${percent(Math.max(most, 0.001), 1)}.`;
  const parts = [];
  if (needed) parts.push(`orange supports <i>${escaped(found.class)}</i>`);
  if (against) parts.push("blue contradicts it");
  return `${said}: ${parts.join("; ")}. Hiding a part changes its probability by at most ${percent(most)}.`;
}
