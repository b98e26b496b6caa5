/** The shelf of examples to pick. */

import { address } from "../shared/api.js";
import { thumbnail } from "../shared/card.js";
import { IMAGES } from "../shared/images.js";
import { shelf } from "../shared/pick.js";
import { change } from "../shared/store.js";
import { escaped } from "../shared/text.js";

export class Gallery {
  constructor(box, take) {
    this.box = box;
    box.onclick = (event) => {
      const ref = event.target.closest("button")?.dataset.ref;
      if (ref) change(take.value === "both" ? { vis: ref, tac: ref } : { [take.value]: ref });
    };
  }

  fill(examples, set) {
    const offers = shelf(examples, set.frames);
    const none = set.frames
      ? "There are no examples. Upload images, or pin a pair in Explore."
      : "The set’s pairs appear with its map, which is being computed. Your own images work meanwhile.";
    this.box.innerHTML = offers.length ? offers.map((one) => offer(one, set)).join("") : `<p class="hint">${none}</p>`;
  }

  mark(refs) {
    for (const button of this.box.querySelectorAll("button")) {
      button.setAttribute("aria-pressed", String(refs.includes(button.dataset.ref)));
    }
  }
}

function offer(one, set) {
  const name = escaped(`${one.truth}, ${one.domain}`);
  return `<button type="button" data-ref="${escaped(one.ref)}" title="${name}" aria-label="${name}"><span>${pictures(one, set)}</span><small>${escaped(one.truth)}</small></button>`;
}

function pictures({ path, pair }, { sprite, frames }) {
  if (path === undefined) {
    return ["photo", "touch"].map((label, i) => thumbnail(sprite, pair + i * frames.pairs, 48, label)).join("");
  }
  const coded = path.split("/").map(encodeURIComponent).join("/");
  return IMAGES.map((modality) => `<img loading="lazy" alt="" src="${address(`example/${coded}/${modality}`)}">`).join(
    "",
  );
}
