/** The map: points on one canvas, marks on another above it; zoom and pan stay the same at every stop. */

import { drawingOn } from "./canvas.js";
import { density } from "./density.js";
import { isDark, isLecture, onTheme } from "./palette.js";
import { Pixels, stampShape } from "./points.js";
import { awaited } from "./ready.js";

const GROUND = { light: "#ffffff", dark: "#0f172a" };
const MARGIN = 0.06; // of the shorter side, kept free around all points
const FITTED = { zoom: 1, dx: 0, dy: 0 };
const KEYS =
  "Points: arrows or two fingers pan, plus and minus or two fingers zoom, 0 fits, N and B step through pairs, " +
  "Enter pins, S selects what is in view, Escape clears the selection";

const eased = (/** @type {number} */ share) => share * share * (3 - 2 * share);
const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Cloud {
  count = 0;
  x = new Float32Array(0); // CSS pixels of each point in the last drawing, as all lengths here
  y = new Float32Array(0);
  /** @type {Layer[]} */
  layers = [];
  /** @type {Positions | null} */
  frame = null;
  ratio = 1; // device pixels of a CSS pixel
  width = 1;
  height = 1;
  view = FITTED;
  /** @type {((view: typeof FITTED) => void) | null} called after every manual zoom and pan */
  onView = null;
  /** @type {Painter[]} functions that draw marks above the points */
  painters = [];
  halves = [true, true]; // whether the map is as wide as the VIS points, and as the TAC points
  top = 0; // at the top, what tools cover
  pending = 0;
  // handles of a glide: its next frame, and what ends the wait for it
  gliding = 0;
  arrived = (/** @type {unknown} */ _) => {};

  /** `count` points: the first half VIS, the second half TAC. @param {HTMLElement} box @param {number} count */
  constructor(box, count) {
    this.box = box;
    this.ground = document.createElement("canvas");
    this.marks = document.createElement("canvas");
    this.marks.tabIndex = 0;
    this.marks.setAttribute("aria-label", KEYS);
    this.marks.setAttribute("role", "img");
    box.append(this.ground, this.marks);
    this.pixels = new Pixels(drawingOn(this.ground, { alpha: false }));
    this.hold(count);
    addEventListener("beforeprint", () => this.print());
    onTheme(() => this.redraw());
    new ResizeObserver(() => this.resize()).observe(box);
    this.resize();
  }

  /** Make room for so many points. @param {number} count */
  hold(count) {
    this.count = count;
    this.x = new Float32Array(count);
    this.y = new Float32Array(count);
    this.layers = [];
    this.frame = null;
  }

  resize() {
    const { width, height } = this.box.getBoundingClientRect();
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    for (const canvas of [this.ground, this.marks]) {
      canvas.width = Math.max(1, Math.round(width * this.ratio));
      canvas.height = Math.max(1, Math.round(height * this.ratio));
    }
    this.width = this.ground.width / this.ratio;
    this.height = this.ground.height / this.ratio;
    this.redraw();
  }

  /** Show other positions: u16 pairs within bounds [[xmin, ymin], [xmax, ymax]]. The map is as wide as its
   * extents, which are those of all stops, so that the scale stays. @param {Positions} frame */
  show(frame) {
    this.stop();
    this.frame = frame;
    this.redraw();
  }

  stop() {
    cancelAnimationFrame(this.gliding);
    this.arrived(0);
  }

  /** Let the points glide to other positions of the same map; at once where motion is not wanted, or nobody looks.
   * @param {Positions} frame @param {number} ms */
  glide(frame, ms) {
    const [{ points: to, bounds }, before] = [frame, this.frame];
    const alike = before?.points.length === to.length && String(before.bounds) === String(bounds);
    if (!before || !alike || calm() || document.hidden || !this.box.checkVisibility()) return this.show(frame);
    this.stop();
    const from = Float32Array.from(before.points);
    const points = new Float32Array(from.length);
    awaited(new Promise((done) => (this.arrived = done)));
    const begun = performance.now();
    const step = (/** @type {number} */ now) => {
      const share = eased(Math.min(1, Math.max(0, (now - begun) / ms)));
      if (share === 1) return this.show(frame);
      for (let i = 0; i < from.length; i++) points[i] = from[i] + share * (to[i] - from[i]);
      this.frame = { ...frame, points };
      this.draw();
      this.gliding = requestAnimationFrame(step);
    };
    return step(begun);
  }

  /** Pixels from u16: x = u·ax + bx, y = v·ay + by; one scale for both axes. */
  transform() {
    const { bounds, extents = [] } = /** @type {Positions} */ (this.frame);
    const [[x0, y0], [x1, y1]] = bounds;
    const none = !this.halves.includes(true); // the fit stays while no point is shown
    const all = extents.filter((box, i) => (none || this.halves[i]) && box[0] <= box[2]);
    /** @param {number} i */
    const end = (i) => (i < 2 ? Math.min : Math.max)(...all.map((box) => box[i])) / 65535;
    const box = all.length ? [0, 1, 2, 3].map(end) : [0, 0, 1, 1];
    const [left, right] = [x0 + box[0] * (x1 - x0), x0 + box[2] * (x1 - x0)];
    const [low, high] = [y0 + box[1] * (y1 - y0), y0 + box[3] * (y1 - y0)];
    const free = MARGIN * Math.min(this.width, this.height);
    const fit = Math.min(
      (this.width - 2 * free) / (right - left || 1),
      (this.height - this.top - 2 * free) / (high - low || 1),
    );
    const scale = fit * this.view.zoom;
    const middle = { x: (left + right) / 2, y: (low + high) / 2 };
    const ox = this.width / 2 + this.view.dx;
    const oy = (this.height + this.top) / 2 + this.view.dy;
    return {
      ax: (scale * (x1 - x0)) / 65535,
      bx: ox + scale * (x0 - middle.x),
      ay: (-scale * (y1 - y0)) / 65535,
      by: oy - scale * (y0 - middle.y),
      scale,
      middle,
      ox,
      oy,
    };
  }

  redraw() {
    this.pending ||= requestAnimationFrame(() => {
      this.pending = 0;
      this.draw();
    });
  }

  draw() {
    if (!this.frame) return;
    const { ax, bx, ay, by } = this.transform();
    const { points } = this.frame;
    const { x, y } = this;
    for (let i = 0; i < this.count; i++) {
      x[i] = points[2 * i] * ax + bx;
      y[i] = points[2 * i + 1] * ay + by;
    }
    const ground = isDark() ? GROUND.dark : GROUND.light;
    this.pixels.begin(this.ground, ground);
    density(this, ground);
    const large = Math.max(isLecture() ? 1.5 : 1, Math.min(this.width, this.height) / 760); // a projector's map
    for (const { style, at, count } of this.layers) {
      const radius = style.radius * large * this.ratio * Math.min(2, this.view.zoom ** 0.3);
      this.pixels.stampAll({ ...style, radius }, at.subarray(0, count), this);
    }
    this.pixels.end();
    this.paintMarks();
  }

  /** Draw at once, as no animation frame comes before the paper, and as shapes: a browser prints no written pixels. */
  print() {
    this.draw();
    this.painters.unshift((x) => {
      for (const { style, at, count } of this.layers)
        for (const point of at.subarray(0, count)) stampShape(x, style, this.place(point));
    });
    this.paintMarks();
    this.painters.shift();
  }

  paintMarks() {
    if (!this.frame) return;
    const context = drawingOn(this.marks);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.marks.width, this.marks.height);
    context.scale(this.ratio, this.ratio);
    for (const paint of this.painters) paint(context, this);
  }

  /** @param {number} point @returns {Point} */
  place(point) {
    return [this.x[point], this.y[point]];
  }

  /** Pixels of what a frame has beyond the points: marks that glide with them. @returns {Point[]} */
  extras() {
    const { ax, bx, ay, by } = this.transform();
    const { points } = /** @type {Positions} */ (this.frame);
    const count = points.length / 2 - this.count;
    return Array.from({ length: count }, (_, i) => {
      const at = 2 * (this.count + i);
      return [points[at] * ax + bx, points[at + 1] * ay + by];
    });
  }

  /** Pixels of a position in map units. @param {Point} place @returns {Point} */
  spot([x, y]) {
    const { scale, middle, ox, oy } = this.transform();
    return [ox + scale * (x - middle.x), oy - scale * (y - middle.y)];
  }

  /** The `wanted` point nearest to a position, within `reach`; or -1.
   * @param {number} px @param {number} py @param {(point: number) => boolean} wanted */
  nearest(px, py, wanted, reach = 12) {
    let best = -1;
    let least = reach ** 2;
    for (let i = 0; i < this.count; i++) {
      const distance = (this.x[i] - px) ** 2 + (this.y[i] - py) ** 2;
      if (distance < least && wanted(i)) {
        least = distance;
        best = i;
      }
    }
    return best;
  }

  /** Zoom by a factor around a position (default: the middle). @param {number} factor */
  zoomBy(factor, px = this.width / 2, py = this.height / 2) {
    const { dx, dy } = this.view;
    const zoom = Math.max(0.5, Math.min(40, this.view.zoom * factor));
    const moved = 1 - zoom / this.view.zoom;
    const mx = px - this.width / 2;
    const my = py - this.height / 2;
    this.setView({ zoom, dx: dx + (mx - dx) * moved, dy: dy + (my - dy) * moved });
  }

  /** @param {number} dx @param {number} dy */
  panBy(dx, dy) {
    this.setView({ ...this.view, dx: this.view.dx + dx, dy: this.view.dy + dy });
  }

  resetView() {
    this.setView(FITTED);
  }

  /** @param {typeof FITTED} view */
  setView(view, quiet = false) {
    const inside = (/** @type {number} */ shift, /** @type {number} */ side) =>
      Math.max(-0.5 * side * view.zoom, Math.min(0.5 * side * view.zoom, shift)); // some points stay in view
    this.view = { ...view, dx: inside(view.dx, this.width), dy: inside(view.dy, this.height) };
    this.redraw();
    if (!quiet) this.onView?.(this.view);
  }
}

/** Return points inside a polygon, by the even-odd rule.
 * @param {Cloud} cloud @param {Point[]} polygon @param {(point: number) => boolean} wanted */
export function inside(cloud, polygon, wanted) {
  const path = new Path2D();
  for (const corner of polygon) path.lineTo(...corner);
  const plain = drawingOn(new OffscreenCanvas(1, 1)); // that of the marks is scaled
  const within = (/** @type {number} */ point) => plain.isPointInPath(path, ...cloud.place(point), "evenodd");
  return Array.from(cloud.x, (_, point) => point).filter((point) => wanted(point) && within(point));
}
