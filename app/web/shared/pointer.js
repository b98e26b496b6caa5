/** Mouse, touch and keys on a map: hover, pick, pan, zoom, lasso. */

import { inside } from "./cloud.js";

const STEP = 40; // CSS pixels that an arrow key pans

const nothing = () => {};
const STILL = { hover: nothing, pick: nothing, lasso: nothing, next: nothing };
Object.assign(STILL, { wanted: () => false, lassoMode: () => false, current: () => -1 });

/** The corners of a canvas in CSS pixels: a lasso around everything in view. */
function corners(canvas) {
  const { clientWidth: wide, clientHeight: high } = canvas;
  return [
    [0, 0],
    [wide, 0],
    [wide, high],
    [0, high],
  ];
}

/**
 * `on`: wanted(point) → bool, hover(point), pick(point), lasso(points), next(by), lassoMode() → bool,
 * current() → point; those left out do nothing. Returns the lasso being drawn, for the painter.
 */
export function listen(cloud, on) {
  on = { ...STILL, ...on };
  const pointer = new Pointer(cloud, on);
  const canvas = cloud.marks;
  for (const kind of ["down", "move", "up", "cancel", "leave"])
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
  constructor(cloud, on) {
    this.cloud = cloud;
    this.on = on;
    this.fingers = new Map();
    /** @type {{polygon: [number, number][] | null}} */
    this.drawing = { polygon: null };
    this.moved = 0;
  }

  /** CSS pixels of an event on the map.
   * @returns {[number, number]} */
  at(event) {
    const box = this.cloud.marks.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    if (event.button) return;
    this.cloud.marks.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, this.at(event));
    this.moved = 0;
    const alone = this.fingers.size === 1;
    if (alone && (this.on.lassoMode() || event.shiftKey)) this.drawing.polygon = [this.at(event)];
    if (!alone) this.drawing.polygon = null;
  }

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

  pinch(id, before, now) {
    const [[, other]] = [...this.fingers].filter(([key]) => key !== id);
    const apart = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
    this.cloud.zoomBy(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  }

  up(event) {
    const { cloud, on } = this;
    const alone = this.fingers.size === 1;
    this.fingers.delete(event.pointerId);
    const { polygon } = this.drawing;
    this.drawing.polygon = null;
    if (alone && this.moved < 5) on.pick(cloud.nearest(...this.at(event), on.wanted));
    else if (polygon && polygon.length > 3) on.lasso(inside(cloud, polygon, on.wanted));
    cloud.paintMarks();
  }

  cancel(event) {
    this.fingers.delete(event.pointerId);
    this.drawing.polygon = null;
  }

  leave() {
    if (!this.fingers.size) this.on.hover(-1);
  }

  wheel(event) {
    if (!event.ctrlKey && !event.metaKey && document.activeElement !== this.cloud.marks) return;
    event.preventDefault(); // without a click on the map or Ctrl, the page scrolls
    this.cloud.zoomBy(Math.exp(-event.deltaY * 0.0016), ...this.at(event));
  }
}

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
    s: () => on.lasso(inside(cloud, corners(cloud.marks), on.wanted)),
    Escape: () => on.lasso([]),
  };
}
