/** Mouse, touch and keys on a map: hover, pick, pan, zoom, lasso. */

import { inside } from "./cloud.js";

const STEP = 40; // CSS pixels that an arrow key pans

/** The corners of a canvas in CSS pixels: a lasso around all that is in view. */
function corners(canvas) {
  const { clientWidth: wide, clientHeight: high } = canvas;
  return [[0, 0], [wide, 0], [wide, high], [0, high]];
}

/**
 * `on` answers: wanted(point) → bool, hover(point), pick(point), lasso(points), lassoMode() → bool.
 * Returns the lasso being drawn, for the painter.
 */
export function listen(cloud, on) {
  const canvas = cloud.marks;
  const fingers = new Map();
  const drawing = { polygon: null };
  let moved = 0;

  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  canvas.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, at(event));
    moved = 0;
    if (fingers.size === 1 && (on.lassoMode() || event.shiftKey)) drawing.polygon = [at(event)];
    if (fingers.size > 1) drawing.polygon = null;
  });

  canvas.addEventListener("pointermove", (event) => {
    const now = at(event);
    const before = fingers.get(event.pointerId);
    if (!before) return on.hover(cloud.nearest(...now, on.wanted));
    moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
    if (drawing.polygon) {
      drawing.polygon.push(now);
      cloud.paintMarks();
    } else if (fingers.size === 2) {
      pinch(event.pointerId, before, now);
    } else {
      cloud.panBy(now[0] - before[0], now[1] - before[1]);
    }
    fingers.set(event.pointerId, now);
  });

  function pinch(id, before, now) {
    const other = [...fingers].find(([key]) => key !== id)[1];
    const apart = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
    cloud.zoomBy(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  }

  canvas.addEventListener("pointerup", (event) => {
    const alone = fingers.size === 1;
    fingers.delete(event.pointerId);
    const polygon = drawing.polygon;
    drawing.polygon = null;
    if (alone && moved < 5) on.pick(cloud.nearest(...at(event), on.wanted));
    else if (polygon && polygon.length > 3) on.lasso(inside(cloud, polygon, on.wanted));
    cloud.paintMarks();
  });
  canvas.addEventListener("pointercancel", (event) => {
    fingers.delete(event.pointerId);
    drawing.polygon = null;
  });
  canvas.addEventListener("pointerleave", () => fingers.size || on.hover(-1));

  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey && document.activeElement !== canvas) return;
    event.preventDefault(); // the page scrolls unless the map was clicked or Ctrl is held
    cloud.zoomBy(Math.exp(-event.deltaY * 0.0016), ...at(event));
  }, { passive: false });
  canvas.addEventListener("dblclick", (event) => cloud.zoomBy(2, ...at(event)));

  const keys = {
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
    s: () => on.lasso(inside(cloud, corners(canvas), on.wanted)),
    Escape: () => on.lasso([]),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  return drawing;
}
