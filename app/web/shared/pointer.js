/** Mouse, touch and keys on a map: hover, pick, pan, zoom, lasso. One finger scrolls the page, two move the map. */

import { inside } from "./cloud.js";

const STEP = 40; // CSS pixels that an arrow key pans

/** @typedef {import("./cloud.js").Cloud} Cloud */
/**
 * What a map's pointer and keys do; those left out do nothing. Points are numbers, -1 for none.
 * @typedef {{wanted: (point: number) => boolean, lassoMode: () => boolean, current: () => number,
 *   hover: (point: number) => unknown, pick: (point: number) => unknown, lasso: (points: number[]) => unknown,
 *   next: (by: number) => unknown}} On
 */
const nothing = () => {};
/** @type {On} */
const STILL = {
  ...{ hover: nothing, pick: nothing, lasso: nothing, next: nothing },
  ...{ wanted: () => false, lassoMode: () => false, current: () => -1 },
};

/** Listen to a map. Returns the lasso being drawn, for the painter. @param {Cloud} cloud @param {Partial<On>} acts */
export function listen(cloud, acts) {
  const on = { ...STILL, ...acts };
  const canvas = cloud.marks;
  /** @type {{polygon: Point[] | null}} */
  const drawing = { polygon: null };
  const keys = keysOf(cloud, on);
  /** @type {Record<string, (event: any) => unknown>} */
  const handlers = {
    ...pointed(cloud, on, drawing),
    touchmove: (/** @type {TouchEvent} */ event) =>
      (event.touches.length > 1 || drawing.polygon) && event.cancelable && event.preventDefault(),
    wheel: (/** @type {WheelEvent} */ event) => {
      if (!event.ctrlKey && !event.metaKey && document.activeElement !== canvas) return;
      event.preventDefault(); // without a click on the map or Ctrl, the page scrolls
      cloud.zoomBy(Math.exp(-event.deltaY * 0.0016), ...placeOf(event));
    },
    dblclick: (event) => cloud.zoomBy(2, ...placeOf(event)),
    keydown: (/** @type {KeyboardEvent} */ event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    },
  };
  for (const [kind, act] of Object.entries(handlers)) canvas.addEventListener(kind, act, { passive: false });
  return drawing;
}

/** CSS pixels of an event on its canvas. @param {MouseEvent} event @returns {Point} */
const placeOf = ({ offsetX, offsetY }) => [offsetX, offsetY];
/** @param {Point} a @param {Point} b */
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

/** Return what a pointer or several fingers do.
 * @param {Cloud} cloud @param {On} on @param {{polygon: Point[] | null}} drawing
 * @returns {Record<string, (event: PointerEvent) => unknown>} */
function pointed(cloud, on, drawing) {
  /** @type {Map<number, Point>} */
  const fingers = new Map();
  let moved = 0;
  /** @param {PointerEvent} event */
  const lift = (event) => {
    fingers.delete(event.pointerId);
    drawing.polygon = null;
  };
  return {
    pointerdown(event) {
      if (event.button) return;
      cloud.marks.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, placeOf(event));
      moved = 0;
      const alone = fingers.size === 1;
      if (alone && (on.lassoMode() || event.shiftKey)) drawing.polygon = [placeOf(event)];
      if (!alone) drawing.polygon = null;
    },
    pointermove(event) {
      const now = placeOf(event);
      const before = fingers.get(event.pointerId);
      if (!before) return on.hover(cloud.nearest(...now, on.wanted));
      moved += distance(now, before);
      const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
      if (drawing.polygon) {
        drawing.polygon.push(now);
        cloud.paintMarks();
      } else if (other && fingers.size === 2) {
        cloud.panBy((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
        cloud.zoomBy(
          (distance(now, other) || 1) / (distance(before, other) || 1),
          (now[0] + other[0]) / 2,
          (now[1] + other[1]) / 2,
        );
      } else if (event.pointerType !== "touch") cloud.panBy(now[0] - before[0], now[1] - before[1]);
      return fingers.set(event.pointerId, now);
    },
    pointerup(event) {
      const alone = fingers.size === 1;
      const { polygon } = drawing;
      lift(event);
      if (alone && moved < 5) on.pick(cloud.nearest(...placeOf(event), on.wanted));
      else if (polygon && polygon.length > 3) on.lasso(inside(cloud, polygon, on.wanted));
      cloud.paintMarks();
    },
    pointercancel: lift,
    pointerleave: () => fingers.size || on.hover(-1),
  };
}

/** @param {Cloud} cloud @param {On} on @returns {Record<string, () => unknown>} */
const keysOf = (cloud, on) => ({
  ArrowLeft: () => cloud.panBy(STEP, 0),
  ArrowRight: () => cloud.panBy(-STEP, 0),
  ArrowUp: () => cloud.panBy(0, STEP),
  ArrowDown: () => cloud.panBy(0, -STEP),
  "+": () => cloud.zoomBy(1.3),
  "=": () => cloud.zoomBy(1.3),
  "-": () => cloud.zoomBy(1 / 1.3),
  0: () => cloud.resetView(),
  n: () => on.next(1),
  b: () => on.next(-1),
  Enter: () => on.pick(on.current()),
  s: () => on.lasso(inside(cloud, corners(cloud.marks), on.wanted)), // all in view
  Escape: () => on.lasso([]),
});

/** @param {HTMLElement} canvas @returns {Point[]} */
const corners = ({ clientWidth: wide, clientHeight: high }) => [
  [0, 0],
  [wide, 0],
  [wide, high],
  [0, high],
];
