/** Pictures replace points when few enough are in view. */

import { thumbnailPair, verdict } from "../shared/card.js";
import { colouring } from "../shared/palette.js";
import { state } from "../shared/store.js";
import { escaped } from "../shared/text.js";

const MOST = 70; // pictures on the map at once
const NEAR = 3; // zoom from which points may become pictures
const SIDE = 38; // CSS pixels

const sheets = new Map(); // address -> image, once it has loaded

function sheet(sprite, onLoad) {
  if (!sheets.has(sprite.url)) {
    const image = new Image();
    sheets.set(sprite.url, image);
    image.onload = onLoad;
    image.src = sprite.url;
  }
  const image = sheets.get(sprite.url);
  return image.complete && image.naturalWidth ? image : null;
}

/** Indices of the points in view; null if there are more than `most`. */
export function inView(cloud, shown, most = MOST) {
  const found = [];
  for (let point = 0; point < cloud.count; point++) {
    if (cloud.x[point] < 0 || cloud.y[point] < 0 || cloud.x[point] > cloud.width || cloud.y[point] > cloud.height)
      continue;
    if (!shown(point)) continue;
    if (found.length === most) return null;
    found.push(point);
  }
  return found;
}

/** A painter; VIS pictures have round corners, TAC pictures square ones, frames have the point's colour. */
export function pictures(scene) {
  return (context, cloud) => {
    const { sprite, frames } = scene;
    cloud.box.classList.remove("pictured");
    if (!sprite || cloud.view.zoom < NEAR) return;
    const points = inView(cloud, scene.shown);
    if (!points) return;
    const image = sheet(sprite, () => cloud.paintMarks());
    if (!image) return;
    cloud.box.classList.add("pictured");
    const chosen = colouring(frames, state.colour);
    const groups = chosen.groups(frames);
    const of = chosen.of(frames, scene.stop);
    for (const point of points) {
      const tac = point >= frames.pairs ? 1 : 0;
      const colour = groups[of(point % frames.pairs, tac)]?.[1] ?? "#64748b";
      tile(context, image, sprite, point, cloud.place(point), colour, tac);
    }
  };
}

function tile(context, image, sprite, point, [x, y], colour, tac) {
  const from = [(point % sprite.columns) * sprite.tile, Math.floor(point / sprite.columns) * sprite.tile];
  context.save();
  context.beginPath();
  context.roundRect(x - SIDE / 2, y - SIDE / 2, SIDE, SIDE, tac ? 2 : SIDE / 2);
  context.lineWidth = 5;
  context.strokeStyle = colour;
  context.stroke();
  context.clip();
  context.drawImage(image, ...from, sprite.tile, sprite.tile, x - SIDE / 2, y - SIDE / 2, SIDE, SIDE);
  context.restore();
}

const PEEK = 76;
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
    box.innerHTML = `${thumbnailPair(scene.frames, scene.sprite, pair, PEEK)}<p><b>${escaped(v.truth)}</b> · ${escaped(v.domain)}</p>`;
    place();
  };
}
