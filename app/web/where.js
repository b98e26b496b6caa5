/** Where in an image the answer comes from: parts that it needs are tinted over the picture. */

import { askOfImage, bytesOf, refused, Refusal } from "./api.js";
import { state } from "./store.js";
import { escaped, percent } from "./text.js";

const NEEDED = [213, 94, 0]; // hiding it takes probability away
const AGAINST = [0, 114, 178]; // hiding it adds some

export async function where(slot, onProblem) {
  const { modality } = slot.dataset;
  const what = slot.querySelector(".what");
  const before = what.textContent;
  what.textContent = "Hiding one part after the other…";
  slot.classList.add("busy");
  try {
    const blob = await bytesOf(state[modality], modality);
    if (!blob) throw new Refusal("The server keeps no images, only what the encoder made of them; choose this file again.");
    const other = modality === "vis" ? state.tac : state.vis;
    const found = await askOfImage("occlusion", blob, { modality, other, order: state.p });
    const most = Math.max(...found.drops.flat());
    slot.querySelector(".picture").append(tint(found));
    slot.querySelector(".picture").classList.add("seen");
    what.innerHTML = `<b>${escaped(found.class)} ${percent(found.probability)}</b> at p = ${state.p.toFixed(2)}: orange parts hold it up (by ${percent(Math.max(0, most))} at most), blue ones speak against it. ${found.seconds} s.`;
  } catch (error) {
    what.textContent = before;
    refused(error, onProblem);
  } finally {
    slot.classList.remove("busy");
  }
}

function tint({ cells, drops }) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = cells;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "Parts of the image that the answer depends on");
  const image = new ImageData(cells, cells);
  const scale = Math.max(0.02, ...drops.flat().map(Math.abs));
  drops.flat().forEach((drop, i) => {
    image.data.set([...(drop > 0 ? NEEDED : AGAINST), Math.round(190 * Math.abs(drop) / scale)], 4 * i);
  });
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}
