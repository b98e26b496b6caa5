/** Pictures of bytes RGB, made smaller: the arithmetic of Pillow, so that results are equal. No DOM here. */

const BITS = 22; // of a weight's fraction

const bicubic = (x) => {
  x = Math.abs(x);
  if (x < 1) return 1.5 * x ** 3 - 2.5 * x * x + 1;
  return x < 2 ? -0.5 * (((x - 5) * x + 8) * x - 4) : 0;
};
const box = (x) => (x > -0.5 && x <= 0.5 ? 1 : 0);
/** name -> [weight of a distance, its reach]
 * @type {Record<string, [(x: number) => number, number]>} */
export const FILTERS = { bicubic: [bicubic, 2], box: [box, 0.5] };

/** For each of `to` output pixels, the first input pixel and its weights as whole numbers; the inputs are
 * `from` pixels, of which `length` count. */
function weightsOf(from, length, to, [filter, reach]) {
  const scale = length / to;
  const stretch = Math.max(1, scale);
  const support = reach * stretch;
  return Array.from({ length: to }, (_, at) => {
    const centre = (at + 0.5) * scale;
    const first = Math.max(0, Math.trunc(centre - support + 0.5));
    const count = Math.min(from, Math.trunc(centre + support + 0.5)) - first;
    const each = Array.from({ length: count }, (_, i) => filter((i + first - centre + 0.5) / stretch));
    const sum = each.reduce((a, b) => a + b, 0);
    const whole = each.map((w) => Math.trunc((w / sum) * 2 ** BITS + (w < 0 ? -0.5 : 0.5)));
    return { first, weights: Int32Array.from(whole) };
  });
}

/** One axis: `many` lines of `from` pixels, `step` bytes apart and `line` bytes from line to line. */
function along(pixels, out, table, many, { line, step, outLine, outStep }) {
  for (let row = 0; row < many; row++) {
    for (let at = 0; at < table.length; at++) {
      const { first, weights } = table[at];
      let r = 1 << (BITS - 1);
      let g = r;
      let b = r;
      for (let i = 0, from = row * line + first * step; i < weights.length; i++, from += step) {
        r += weights[i] * pixels[from];
        g += weights[i] * pixels[from + 1];
        b += weights[i] * pixels[from + 2];
      }
      const to = row * outLine + at * outStep;
      out[to] = r >> BITS; // a clamped array
      out[to + 1] = g >> BITS;
      out[to + 2] = b >> BITS;
    }
  }
}

/** Resize {pixels, width, height} as Image.resize does, bicubic unless `filter` says otherwise.
 * `length`: the part of the width and of the height that counts, if a last pixel is of fewer. */
export function resized(picture, wide, high, filter = FILTERS.bicubic, length = [picture.width, picture.height]) {
  const across = (one) => {
    if (wide === one.width && length[0] === wide) return one;
    const pixels = new Uint8ClampedArray(3 * wide * one.height);
    const steps = { line: 3 * one.width, step: 3, outLine: 3 * wide, outStep: 3 };
    along(one.pixels, pixels, weightsOf(one.width, length[0], wide, filter), one.height, steps);
    return { pixels, width: wide, height: one.height };
  };
  const down = (one) => {
    if (high === one.height && length[1] === high) return one;
    const pixels = new Uint8ClampedArray(3 * one.width * high);
    const steps = { line: 3, step: 3 * one.width, outLine: 3, outStep: 3 * one.width };
    along(one.pixels, pixels, weightsOf(one.height, length[1], high, filter), one.width, steps);
    return { pixels, width: one.width, height: high };
  };
  const tall = picture.height > 100 * picture.width && high < picture.height;
  return tall ? across(down(picture)) : down(across(picture));
}

/** The mean of `across` × `down` pixels each, as Image.reduce has it; the last ones may be of fewer. */
export function reduced({ pixels, width, height }, across, down = across) {
  if (across === 1 && down === 1) return { pixels, width, height };
  const wide = Math.ceil(width / across);
  const high = Math.ceil(height / down);
  const out = new Uint8ClampedArray(3 * wide * high);
  for (let y = 0; y < high; y++) {
    for (let x = 0; x < wide; x++) {
      const right = Math.min(width, (x + 1) * across);
      const bottom = Math.min(height, (y + 1) * down);
      const count = (right - x * across) * (bottom - y * down);
      const share = Math.trunc(Math.fround(2 ** 32 / (256 * count)));
      let [r, g, b] = [0, 0, 0].fill(Math.trunc(count / 2));
      for (let row = y * down; row < bottom; row++) {
        for (let from = 3 * (row * width + x * across), end = 3 * (row * width + right); from < end; from += 3) {
          r += pixels[from];
          g += pixels[from + 1];
          b += pixels[from + 2];
        }
      }
      const to = 3 * (y * wide + x);
      [r, g, b].forEach((sum, i) => (out[to + i] = Math.floor((sum * share) / 2 ** 24)));
    }
  }
  return { pixels: out, width: wide, height: high };
}

/** The picture within `most` × `most` pixels, as Image.thumbnail makes it. */
export function thumbnail(picture, most) {
  const { width, height } = picture;
  if (width <= most && height <= most) return picture;
  const aspect = width / height;
  const side = (number, far) => {
    const [low, high] = [Math.max(1, Math.floor(number)), Math.max(1, Math.ceil(number))];
    return far(low) <= far(high) ? low : high;
  };
  const wide = aspect >= 1 ? most : side(most * aspect, (n) => Math.abs(aspect - n / most));
  const high = aspect >= 1 ? side(most / aspect, (n) => (n ? Math.abs(aspect - most / n) : 0)) : most;
  const fewer = (from, to) => Math.max(1, Math.trunc(from / to / 2)); // reducing_gap = 2
  const [across, down] = [fewer(width, wide), fewer(height, high)];
  if (across === 1 && down === 1) return resized(picture, wide, high);
  const length = [width / across, height / down].map(Math.fround); // as Pillow keeps a box
  return resized(reduced(picture, across, down), wide, high, FILTERS.bicubic, length);
}
