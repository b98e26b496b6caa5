/** Mouse, touch and keys on a map: hover, pick, pan, zoom, lasso. */

import { inside } from "./cloud.js";

const STEP = 40; // CSS pixels that an arrow key pans

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

/** Listen to a map. Returns the lasso being drawn, for the painter.
 * @param {import("./cloud.js").Cloud} cloud @param {Partial<On>} acts @returns {{polygon: Point[] | null}} */
export function listen(cloud, acts) {
  const on = { ...STILL, ...acts };
  const pointer = new Pointer(cloud, on);
  const canvas = cloud.marks;
  for (const kind of /** @type {const} */ (["down", "move", "up", "cancel", "leave"]))
    canvas.addEventListener(`pointer${kind}`, (event) => pointer[kind](event));
  canvas.addEventListener("wheel", (event) => pointer.wheel(event), { passive: false });
  canvas.addEventListener("dblclick", (event) => cloud.zoomBy(2, ...pointer.at(event)));
  const keys = keysOf(cloud, on);
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  return pointer.drawing;
}

class Pointer {
  /** @type {Map<number, Point>} */
  fingers = new Map();
  /** @type {{polygon: Point[] | null}} */
  drawing = { polygon: null };
  moved = 0;

  /** @param {import("./cloud.js").Cloud} cloud @param {On} on */
  constructor(cloud, on) {
    this.cloud = cloud;
    this.on = on;
  }

  /** CSS pixels of an event on the map. @param {MouseEvent} event @returns {Point} */
  at(event) {
    const box = this.cloud.marks.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  /** @param {PointerEvent} event */
  down(event) {
    if (event.button) return;
    this.cloud.marks.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, this.at(event));
    this.moved = 0;
    const alone = this.fingers.size === 1;
    if (alone && (this.on.lassoMode() || event.shiftKey)) this.drawing.polygon = [this.at(event)];
    if (!alone) this.drawing.polygon = null;
  }

  /** @param {PointerEvent} event */
  move(event) {
    const { cloud, fingers, drawing } = this;
    const now = this.at(event);
    const before = fingers.get(event.pointerId);
    if (!before) return this.on.hover(cloud.nearest(...now, this.on.wanted));
    this.moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
    if (drawing.polygon) {
      drawing.polygon.push(now);
      cloud.paintMarks();
    } else if (fingers.size === 2) this.pinch(event.pointerId, before, now);
    else cloud.panBy(now[0] - before[0], now[1] - before[1]);
    return fingers.set(event.pointerId, now);
  }

  /** @param {number} id @param {Point} before @param {Point} now */
  pinch(id, before, now) {
    const [[, other]] = [...this.fingers].filter(([key]) => key !== id);
    /** @param {Point} a */
    const apart = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
    this.cloud.zoomBy(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  }

  /** @param {PointerEvent} event */
  up(event) {
    const { cloud, on } = this;
    const alone = this.fingers.size === 1;
    const { polygon } = this.drawing;
    this.cancel(event);
    if (alone && this.moved < 5) on.pick(cloud.nearest(...this.at(event), on.wanted));
    else if (polygon && polygon.length > 3) on.lasso(inside(cloud, polygon, on.wanted));
    cloud.paintMarks();
  }

  /** @param {PointerEvent} event */
  cancel(event) {
    this.fingers.delete(event.pointerId);
    this.drawing.polygon = null;
  }

  leave() {
    if (!this.fingers.size) this.on.hover(-1);
  }

  /** @param {WheelEvent} event */
  wheel(event) {
    if (!event.ctrlKey && !event.metaKey && document.activeElement !== this.cloud.marks) return;
    event.preventDefault(); // without a click on the map or Ctrl, the page scrolls
    this.cloud.zoomBy(Math.exp(-event.deltaY * 0.0016), ...this.at(event));
  }
}

/** @param {import("./cloud.js").Cloud} cloud @param {On} on @returns {Record<string, () => unknown>} */
function keysOf(cloud, on) {
  return {
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
    s: () => on.lasso(inView(cloud).filter(on.wanted)),
    Escape: () => on.lasso([]),
  };
}

/** The points within the canvas. @param {import("./cloud.js").Cloud} cloud */
const inView = ({ count, x, y, width, height }) =>
  Array.from({ length: count }, (_, i) => i).filter((i) => x[i] > 0 && x[i] < width && y[i] > 0 && y[i] < height);
