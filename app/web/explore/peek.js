/** The pair's two pictures beside the pointer. */

import { thumbnailPair, verdict } from "../shared/card.js";
import { escaped } from "../shared/text.js";

const SIDE = 76;
const AWAY = 18; // CSS pixels from the pointer

/** Returns show(pair or -1): the pictures follow the pointer over `area`. */
export function peek(box, area, scene) {
  let at = [0, 0];
  const place = () => {
    const { width, height } = box.getBoundingClientRect();
    const left = at[0] + AWAY + width > innerWidth ? at[0] - AWAY - width : at[0] + AWAY;
    const top = Math.max(4, Math.min(innerHeight - height - 4, at[1] - height / 2));
    box.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
  };
  area.addEventListener("pointermove", (event) => {
    at = [event.clientX, event.clientY];
    if (!box.hidden) place();
  });
  area.addEventListener("pointerleave", () => {
    box.hidden = true;
  });
  return (pair, pointed) => {
    box.hidden = pair < 0 || !pointed || !scene.sprite;
    if (box.hidden) return;
    const v = verdict(scene.frames, pair, scene.stop);
    box.innerHTML = `${thumbnailPair(scene.frames, scene.sprite, pair, SIDE)}<p><b>${escaped(v.truth)}</b> · ${escaped(v.domain)}</p>`;
    place();
  };
}
