/** Nearest neighbours in the full width of the features, from the server on request. */

import { ask, inSet, refused } from "../shared/api.js";
import { thumbnail } from "../shared/card.js";

/** Request the neighbours of a point; `box` shows the progress, or why there are none. */
export async function findNeighbours(box, { set, point, stage, p }) {
  if (box) box.textContent = "Computing this stage for the whole set…";
  try {
    return (await ask(inSet("neighbours", set), { point, stage, order: p })).neighbours;
  } catch (error) {
    refused(error, (sentence) => {
      if (box) box.textContent = sentence;
    });
    return [];
  }
}

/** Show neighbours as pictures; a click picks one. */
export function showNeighbours(box, found, { frames, sprite }, onPick) {
  box.innerHTML = found
    .map(({ point, cosine }) => {
      const tac = point >= frames.pairs;
      const own = point % frames.pairs;
      const name = `${tac ? "TAC" : "VIS"} of pair ${own}, ${frames.classes[frames.label[own]]}, ${frames.domains[frames.domain[own]]}, cosine ${cosine.toFixed(3)}`;
      return `<button type="button" data-point="${point}" title="${name}" aria-label="${name}">${thumbnail(sprite, point, 48, tac ? "TAC" : "VIS")}<small>${tac ? "TAC" : "VIS"} ${cosine.toFixed(2)}</small></button>`;
    })
    .join("");
  box.onclick = (event) => {
    const button = event.target.closest("[data-point]");
    if (button) onPick(+button.dataset.point);
  };
}
