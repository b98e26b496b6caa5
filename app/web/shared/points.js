/** Draw thousands of small shapes fast: stamp ready-made masks into pixels, no paths. */

import { drawingOn } from "./canvas.js";
import { rgb } from "./palette.js";

const SHAPES = {
  circle: (x, r) => x.arc(0, 0, r, 0, 7),
  triangle: (x, r) => {
    const s = r * 1.25;
    x.moveTo(0, -s);
    x.lineTo(s, s * 0.8);
    x.lineTo(-s, s * 0.8);
    x.closePath();
  },
};
const stamps = new Map();

/** Draw one shape at a place, as a path. */
export function stampShape(x, { shape, colour, radius, alpha }, left, top) {
  x.save();
  x.translate(left, top);
  x.globalAlpha = alpha;
  x.fillStyle = colour;
  x.beginPath();
  SHAPES[shape](x, radius);
  x.fill();
  x.restore();
}

/** A small picture of one shape: premultiplied colours, and the transparency. */
function stamp({ shape, colour, radius, alpha }) {
  const key = `${shape} ${colour} ${radius} ${alpha}`;
  if (stamps.has(key)) return stamps.get(key);
  const side = 2 * Math.ceil(radius * 1.4 + 1) + 1;
  const canvas = new OffscreenCanvas(side, side);
  const x = drawingOn(canvas);
  x.translate(side / 2, side / 2);
  x.beginPath();
  SHAPES[shape](x, radius);
  x.fillStyle = colour;
  x.fill();
  const raw = x.getImageData(0, 0, side, side).data;
  const rows = [];
  for (let i = 0; i < side * side; i++) {
    const a = (raw[4 * i + 3] / 255) * alpha;
    if (a < 0.02) continue;
    const dx = (i % side) - (side >> 1);
    const dy = Math.floor(i / side) - (side >> 1);
    rows.push([dx, dy, raw[4 * i], raw[4 * i + 1], raw[4 * i + 2], a]);
  }
  const made = {
    reach: side >> 1,
    count: rows.length,
    dx: Int16Array.from(rows, (r) => r[0]),
    dy: Int16Array.from(rows, (r) => r[1]),
    // 8.8 fixed point: colour × alpha, and 256 × (1 − alpha)
    r: Int32Array.from(rows, (r) => Math.round(r[2] * r[5] * 256)),
    g: Int32Array.from(rows, (r) => Math.round(r[3] * r[5] * 256)),
    b: Int32Array.from(rows, (r) => Math.round(r[4] * r[5] * 256)),
    keep: Int32Array.from(rows, (r) => Math.round(256 * (1 - r[5]))),
    solid: Uint32Array.from(rows, (r) => (r[5] > 0.995 ? (0xff000000 | (r[4] << 16) | (r[3] << 8) | r[2]) >>> 0 : 0)),
  };
  if (stamps.size > 400) stamps.clear();
  stamps.set(key, made);
  return made;
}

export class Pixels {
  image = new ImageData(1, 1);
  words = new Uint32Array(1); // its pixels
  offsets = new Map(); // stamp -> places of its pixels

  constructor(context) {
    this.context = context;
  }

  /** Begin a picture of `width` × `height` device pixels on one colour. */
  begin(width, height, ground) {
    if (this.image.width !== width || this.image.height !== height) {
      this.image = new ImageData(width, height);
      this.words = new Uint32Array(this.image.data.buffer);
      this.offsets = new Map();
    }
    const [r, g, b] = rgb(ground);
    this.words.fill((0xff000000 | (b << 16) | (g << 8) | r) >>> 0);
  }

  /** Stamp one shape at many places: `at` holds indices into the device coordinates x, y. */
  stampAll(style, at, count, x, y) {
    const s = stamp(style);
    const { width, height } = this.image;
    const words = this.words;
    const shift = this.shifts(s, width);
    const low = s.reach;
    const right = width - s.reach - 1;
    const bottom = height - s.reach - 1;
    for (let n = 0; n < count; n++) {
      const i = at[n];
      const cx = x[i] | 0;
      const cy = y[i] | 0;
      if (cx < low || cy < low || cx > right || cy > bottom) continue;
      const centre = cy * width + cx;
      for (let k = 0; k < s.count; k++) {
        const to = centre + shift[k];
        if (s.solid[k]) {
          words[to] = s.solid[k];
          continue;
        }
        const old = words[to];
        const keep = s.keep[k];
        const r = (s.r[k] + (old & 255) * keep) >> 8;
        const g = (s.g[k] + ((old >> 8) & 255) * keep) >> 8;
        const b = (s.b[k] + ((old >> 16) & 255) * keep) >> 8;
        words[to] = 0xff000000 | (b << 16) | (g << 8) | r;
      }
    }
  }

  shifts(s, width) {
    let made = this.offsets.get(s);
    if (!made) {
      made = Int32Array.from(s.dx, (dx, k) => s.dy[k] * width + dx);
      this.offsets.set(s, made);
    }
    return made;
  }

  end() {
    this.context.putImageData(this.image, 0, 0);
  }
}
