/** A hint for new visitors: what to drag. It disappears at the first drag, or after a while. */

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
