/** Draw thousands of small shapes fast: stamp ready-made masks into pixels, no paths. */

import { drawingOn } from "./canvas.js";
import { rgb } from "./palette.js";

/** @typedef {CanvasRenderingContext2D} Context */
/** The path of a shape around a place; a triangle is larger, so that both look alike.
 * @type {Record<Style["shape"], (context: Context, place: Point, radius: number) => void>} */
export const SHAPES = {
  circle: (context, [x, y], r) => context.arc(x, y, r, 0, 7),
  triangle: (context, [x, y], r) => {
    const s = r * 1.25;
    context.moveTo(x, y - s);
    context.lineTo(x + s, y + s * 0.8);
    context.lineTo(x - s, y + s * 0.8);
    context.closePath();
  },
};
/** The same as paths of SVG.
 * @type {Record<Style["shape"], (x: number, y: number, radius: number) => string>} */
export const OUTLINES = {
  circle: (x, y, r) => `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`,
  triangle: (x, y, r) => `M${x} ${y - 1.25 * r}l${1.25 * r} ${2.25 * r}h${-2.5 * r}z`,
};
/** @typedef {ReturnType<typeof made>} Stamp */
/** @type {Map<string, Stamp>} */
const stamps = new Map();

/** Draw one shape at a place, as a path. @param {Context} context @param {Style} style @param {Point} place */
export function stampShape(context, { shape, colour, radius, alpha }, place) {
  context.globalAlpha = alpha;
  context.fillStyle = colour;
  context.beginPath();
  SHAPES[shape](context, place, radius);
  context.fill();
  context.globalAlpha = 1;
}

/** Return the picture of a point's style; it is made once. @param {Style} style */
function stamp(style) {
  const key = Object.values(style).join(" ");
  let found = stamps.get(key);
  if (!found) {
    if (stamps.size > 400) stamps.clear();
    stamps.set(key, (found = made(style)));
  }
  return found;
}

/** Return a small picture of one shape: premultiplied colours, and the transparency. @param {Style} style */
function made({ shape, colour, radius, alpha }) {
  const side = 2 * Math.ceil(radius * 1.4 + 1) + 1;
  const x = drawingOn(new OffscreenCanvas(side, side));
  stampShape(x, { shape, colour, radius, alpha: 1 }, [side / 2, side / 2]);
  const raw = x.getImageData(0, 0, side, side).data;
  const rows = [];
  for (let i = 0; i < side * side; i++) {
    const a = (raw[4 * i + 3] / 255) * alpha;
    if (a < 0.02) continue;
    const dx = (i % side) - (side >> 1);
    const dy = Math.floor(i / side) - (side >> 1);
    rows.push([dx, dy, raw[4 * i], raw[4 * i + 1], raw[4 * i + 2], a]);
  }
  return {
    reach: side >> 1,
    count: rows.length,
    dx: Int16Array.from(rows, (r) => r[0]),
    dy: Int16Array.from(rows, (r) => r[1]),
    // 8.8 fixed point: colour × alpha, and 256 × (1 − alpha)
    r: Int32Array.from(rows, (r) => Math.round(r[2] * r[5] * 256)),
    g: Int32Array.from(rows, (r) => Math.round(r[3] * r[5] * 256)),
    b: Int32Array.from(rows, (r) => Math.round(r[4] * r[5] * 256)),
    keep: Int32Array.from(rows, (r) => Math.round(256 * (1 - r[5]))),
  };
}

/** Return an opaque pixel. @param {number} r @param {number} g @param {number} b */
export const word = (r, g, b) => (0xff000000 | (b << 16) | (g << 8) | r) >>> 0;

export class Pixels {
  image = new ImageData(1, 1);
  words = new Uint32Array(1); // its pixels
  /** @type {Map<Stamp, Int32Array>} */
  offsets = new Map(); // stamp -> places of its pixels

  /** @param {Context} context */
  constructor(context) {
    this.context = context;
  }

  /** Begin a picture of some device pixels on one colour. @param {Record<"width" | "height", number>} size
   * @param {string} ground */
  begin({ width, height }, ground) {
    if (this.image.width !== width || this.image.height !== height) {
      this.image = new ImageData(width, height);
      this.words = new Uint32Array(this.image.data.buffer);
      this.offsets = new Map();
    }
    const [r, g, b] = rgb(ground);
    this.words.fill(word(r, g, b));
  }

  /** Stamp one shape at many places: `at` holds indices into the cloud's coordinates.
   * @param {Style} style @param {Int32Array} at @param {Pick<import("./cloud.js").Cloud, "x" | "y" | "ratio">} cloud */
  stampAll(style, at, { x, y, ratio }) {
    const s = stamp(style);
    const { width, height } = this.image;
    const words = this.words;
    const shift = this.shifts(s, width);
    const low = s.reach;
    const right = width - s.reach - 1;
    const bottom = height - s.reach - 1;
    for (let n = 0; n < at.length; n++) {
      const cx = (x[at[n]] * ratio) | 0;
      const cy = (y[at[n]] * ratio) | 0;
      if (cx < low || cy < low || cx > right || cy > bottom) continue;
      const centre = cy * width + cx;
      for (let k = 0; k < s.count; k++) {
        const to = centre + shift[k];
        const old = words[to];
        const keep = s.keep[k];
        const r = (s.r[k] + (old & 255) * keep) >> 8;
        const g = (s.g[k] + ((old >> 8) & 255) * keep) >> 8;
        const b = (s.b[k] + ((old >> 16) & 255) * keep) >> 8;
        words[to] = 0xff000000 | (b << 16) | (g << 8) | r;
      }
    }
  }

  /** @param {Stamp} stamp @param {number} width */
  shifts(stamp, width) {
    let found = this.offsets.get(stamp);
    if (!found) this.offsets.set(stamp, (found = Int32Array.from(stamp.dx, (dx, k) => stamp.dy[k] * width + dx)));
    return found;
  }

  end() {
    this.context.putImageData(this.image, 0, 0);
  }
}
