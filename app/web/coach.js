/** A word for a new visitor: what to drag. It goes with the first drag and does not come back. */

import { watch } from "./store.js";

export function coach(bar) {
  const bubble = bar.querySelector(".coach");
  if (!bubble) return;
  bubble.hidden = false;
  const off = watch(["p"], () => {
    bubble.hidden = true;
    off();
  });
}
