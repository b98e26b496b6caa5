/** Pictures replace points when few enough are in view, and stand at the pointer. */

import { thumbnailPair, verdict } from "../shared/card.js";
import { colouring } from "../shared/palette.js";
import { sensorOf } from "../shared/tables.js";
import { $, html, put, scene, send, state } from "./root.js";
import { painted } from "./scene.js";

const MOST = 70; // pictures on the map at once
const NEAR = 3; // zoom from which points may become pictures
const SIDE = 38; // CSS pixels
const PEEK = 76;
const AWAY = 18; // CSS pixels from the pointer

/** Address -> image, once it has loaded. @type {Map<string, HTMLImageElement>} */
const sheets = new Map();

/** Return a sheet of pictures; null until it has loaded. @param {string} url @param {() => void} onLoad */
export function sheet(url, onLoad) {
  const image = sheets.get(url) ?? Object.assign(new Image(), { onload: onLoad, src: url });
  sheets.set(url, image);
  return image.complete && image.naturalWidth ? image : null;
}

/** Return indices of the points in view; null if there are more than `most`.
 * @param {Pick<import("../shared/cloud.js").Cloud, "count" | "x" | "y" | "width" | "height">} cloud
 * @param {Wanted} shown */
function inView({ count, x, y, width, height }, shown, most = MOST) {
  const points = [];
  for (let point = 0; point < count; point++) {
    if (x[point] < 0 || y[point] < 0 || x[point] > width || y[point] > height || !shown(point)) continue;
    if (points.length === most) return null;
    points.push(point);
  }
  return points;
}

/** VIS pictures have round corners, TAC pictures square ones, frames have the point's colour. @type {Painter} */
export function pictures(context, cloud) {
  const { sprite, frames, stop, mask } = scene;
  cloud.box.classList.remove("pictured");
  if (!sprite || cloud.view.zoom < NEAR) return;
  const points = inView(cloud, (point) => mask[point] === 1);
  const image = points && sheet(sprite.url, () => cloud.paintMarks());
  if (!image) return;
  cloud.box.classList.add("pictured");
  const coloured = painted(scene, state);
  const chosen = colouring(coloured, state.colour);
  const groups = chosen.groups(coloured);
  const of = chosen.of(coloured, stop);
  const { tile, columns } = sprite;
  for (const point of points) {
    const tac = point >= frames.pairs;
    const [left, top] = cloud.place(point).map((v) => v - SIDE / 2);
    context.save();
    context.beginPath();
    context.roundRect(left, top, SIDE, SIDE, tac ? 2 : SIDE / 2);
    context.lineWidth = 5;
    context.strokeStyle = groups[of(point % frames.pairs, +tac)]?.[1] ?? "#64748b";
    context.stroke();
    context.clip();
    const from = [(point % columns) * tile, Math.floor(point / columns) * tile];
    context.drawImage(image, from[0], from[1], tile, tile, left, top, SIDE, SIDE);
    context.restore();
  }
}

/** Place the pictures at the pointer. */
function follow() {
  const box = $(".peek");
  const [x, y] = scene.pointer;
  const { width, height } = box.getBoundingClientRect();
  const left = x + AWAY + width > innerWidth ? x - AWAY - width : x + AWAY;
  const top = Math.max(4, Math.min(innerHeight - height - 4, y - height / 2));
  box.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
}

/** Let the pictures follow the pointer over the maps. */
export function listen() {
  const area = $(".maps");
  area.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    send("arrived", { pointer: [event.clientX, event.clientY] });
    if (!$(".peek").hidden) follow();
  });
  area.addEventListener("pointerleave", () => ($(".peek").hidden = true));
}

/** Show the pictures of a pair, -1 for none, at the pointer. @param {number} pair @param {boolean} pointed */
export function peek(pair, pointed) {
  const { frames, sprite, stop } = scene;
  const box = $(".peek");
  box.hidden = pair < 0 || !pointed || !sprite;
  if (box.hidden) return;
  const { truth, domain } = verdict(painted(scene, state), pair, stop);
  put(box, html`${thumbnailPair(frames, sprite, pair, PEEK)}<p><b>${truth}</b> · ${sensorOf(domain)}</p>`);
  follow();
}
