/** Nearest neighbours in the full width of the features, from the server on request. */

import { ask, refused } from "../shared/api.js";
import { thumbnail } from "../shared/card.js";

/** Request neighbours, show thumbnails, and return the points to mark on the map. */
export async function findNeighbours(box, { frames, sprite, point: of, stage, p, onPick }) {
  box.textContent = "Computing this stage for the whole set…";
  let found;
  try {
    found = (await ask("neighbours", { point: of, stage, order: p })).neighbours;
  } catch (error) {
    refused(error, (sentence) => {
      box.textContent = sentence;
    });
    return [];
  }
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
  return found.map(({ point }) => point);
}
