/** A visitor's file to upright pixels RGB, by the browser's decoders, within the limits of the server. */

import { drawingOn } from "../shared/canvas.js";
import { Refusal } from "../shared/refusal.js";
import { PICTURE } from "./rules.js";

const { MOST_JPEG, MOST, SHORT_SIDE, REDUCED, LEAST_SIDE, STRIP } = PICTURE;
const UNREAD =
  "is no picture that this browser reads, or is cut short or damaged; save it as PNG or JPEG and try again.";

/** @param {Uint8Array} bytes @param {number} at @param {number} length */
const text = (bytes, at, length) => String.fromCharCode(...bytes.subarray(at, at + length));
/** @param {Uint8Array} bytes */
const isJpeg = (bytes) => text(bytes, 0, 2) === "\xff\xd8";

/** The integer by which the sides of a picture are divided. @param {number} width @param {number} height */
function factor(width, height) {
  const short = Math.min(width, height);
  let by = Math.max(1, Math.floor(short / SHORT_SIDE));
  while (width * height > REDUCED * by ** 2 && Math.floor(short / (by + 1)) >= LEAST_SIDE) by += 1;
  return by;
}

/** The factors one after the other: a JPEG is first made smaller by 2, 4 or 8.
 * @param {boolean} jpeg @param {number} width @param {number} height */
export function factors(jpeg, width, height) {
  const wanted = factor(width, height);
  const first = jpeg ? ([8, 4, 2].find((scale) => scale <= wanted) ?? 1) : wanted;
  return [first, jpeg ? factor(Math.ceil(width / first), Math.ceil(height / first)) : 1];
}

/** Whether a PNG or a JPEG ends as its kind does, whatever follows it; browsers show a part of one that was cut
 * short. @param {Uint8Array} bytes */
export function whole(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 8;
  if (text(bytes, 1, 3) === "PNG") {
    while (at + 12 <= bytes.length && text(bytes, at + 4, 4) !== "IEND") at += 12 + view.getUint32(at);
    return at + 12 <= bytes.length;
  }
  if (!isJpeg(bytes)) return true;
  at = 2;
  while (at + 4 < bytes.length && bytes[at + 1] !== 0xda) at += bytes[at + 1] === 0xff ? 1 : 2 + view.getUint16(at + 2);
  do at = bytes.indexOf(0xff, at + 2) - 1;
  while (at > 0 && bytes[at + 2] !== 0xd9);
  return at > 0;
}

/** The mean of `by` × `by` pixels each, as Pillow's Image.reduce has it; the last ones may be of fewer.
 * @param {{ pixels: ArrayLike<number>, width: number, height: number }} picture @param {number} by
 * @param {number} step from one pixel to the next @returns {Raster} */
export function reduced({ pixels, width, height }, by, step = 3) {
  const [wide, high] = [Math.ceil(width / by), Math.ceil(height / by)];
  const out = new Uint8Array(3 * wide * high);
  for (let to = 0; to < out.length; to++) {
    const left = (Math.floor(to / 3) % wide) * by;
    const top = Math.floor(to / 3 / wide) * by;
    const [right, bottom] = [Math.min(width, left + by), Math.min(height, top + by)];
    const count = (right - left) * (bottom - top);
    const share = Math.trunc(Math.fround(2 ** 32 / (256 * count)));
    let sum = Math.trunc(count / 2);
    for (let y = top; y < bottom; y++)
      for (let x = left; x < right; x++) sum += pixels[step * (y * width + x) + (to % 3)];
    out[to] = Math.floor((sum * share) / 2 ** 24);
  }
  return { pixels: out, width: wide, height: high };
}

/** The pixels of a bitmap over white, strip by strip, their sides divided by `by`.
 * @param {ImageBitmap} bitmap @param {number} by @returns {Raster} */
function pixelsOf(bitmap, by) {
  const [width, height] = [Math.ceil(bitmap.width / by), Math.ceil(bitmap.height / by)];
  const pixels = new Uint8Array(3 * width * height);
  const rows = Math.max(1, Math.floor(STRIP / (bitmap.width * by))); // of the result, in a strip
  const brush = drawingOn(new OffscreenCanvas(bitmap.width, rows * by), { willReadFrequently: true });
  brush.fillStyle = "white";
  for (let row = 0; row < height; row += rows) {
    const high = Math.min(rows * by, bitmap.height - row * by);
    brush.fillRect(0, 0, bitmap.width, high);
    brush.drawImage(bitmap, 0, -row * by);
    const strip = brush.getImageData(0, 0, bitmap.width, high);
    pixels.set(reduced({ pixels: strip.data, width: bitmap.width, height: high }, by, 4).pixels, 3 * width * row);
  }
  return { pixels, width, height };
}

/** The pixels of a file's bytes, and `full`, its size before; a Refusal otherwise.
 * @param {Uint8Array} bytes @returns {Promise<Raster & { full: [width: number, height: number] }>} */
export async function decoded(bytes, name = "the image") {
  if (text(bytes, 8, 8) === "WEBPVP8X" && bytes[20] & 8)
    throw new Refusal(`'${name}' is a WebP with EXIF, which browsers turn differently; save it as PNG or JPEG.`);
  const options = /** @type {ImageBitmapOptions} */ ({ colorSpaceConversion: "none", imageOrientation: "from-image" });
  const file = new Blob([/** @type {any} */ (bytes)]);
  const bitmap = whole(bytes) && (await createImageBitmap(file, options).catch(() => null));
  if (!bitmap) throw new Refusal(`'${name}' ${UNREAD}`);
  const { width, height } = bitmap;
  const most = isJpeg(bytes) ? MOST_JPEG : MOST;
  if (width * height > most)
    throw new Refusal(`'${name}' has more than ${most / 1e6} megapixels; scale it down and try again.`);
  if (Math.min(width, height) < LEAST_SIDE)
    throw new Refusal(
      `'${name}' is ${width} × ${height} pixels; a side needs ${LEAST_SIDE} or more for a surface to be seen.`,
    );
  const [first, second] = factors(isJpeg(bytes), width, height);
  const picture = reduced(pixelsOf(bitmap, first), second);
  bitmap.close();
  return { ...picture, full: [width, height] };
}
