/** A word for a new visitor: what to drag. It goes with the first drag, or after a while. */

import { watch } from "../shared/store.js";

const STAYS = 9000; // milliseconds

export function coach(bar) {
  const bubble = bar.querySelector(".coach");
  if (!bubble) return;
  bubble.hidden = false;
  const gone = () => {
    bubble.hidden = true;
    off();
    clearTimeout(waiting);
  };
  const off = watch(["p", "stage", "part", "mode"], gone);
  const waiting = setTimeout(gone, STAYS);
}
