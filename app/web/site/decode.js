/** A visitor's file to upright pixels RGB, by the browser's decoders, within the limits of the server. */

import { drawingOn } from "../shared/canvas.js";
import { Refused } from "./refusal.js";

const MOST_PIXELS = 64e6; // of a JPEG
const PLAIN_PIXELS = 24e6; // of other kinds
const SHORT_SIDE = 1024; // lower limit of a reduced picture
const REDUCED_PIXELS = 6e6; // upper limit of it
const LEAST_SIDE = 8;
const STRIP_PIXELS = 1e6;
const UNREAD =
  "is no picture that this browser reads, or is cut short or damaged; save it as PNG or JPEG and try again.";

const text = (bytes, at, length) => String.fromCharCode(...bytes.subarray(at, at + length));

/** The integer by which the sides of a picture are divided. */
function factor(width, height) {
  const short = Math.min(width, height);
  let found = Math.max(1, Math.floor(short / SHORT_SIDE));
  while (width * height > REDUCED_PIXELS * found ** 2 && Math.floor(short / (found + 1)) >= LEAST_SIDE) found += 1;
  return found;
}

/** The factors one after the other: a JPEG is first made smaller by 2, 4 or 8. */
export function factors(isJpeg, width, height) {
  const wanted = factor(width, height);
  const first = isJpeg ? ([8, 4, 2].find((scale) => scale <= wanted) ?? 1) : wanted;
  return [first, isJpeg ? factor(Math.ceil(width / first), Math.ceil(height / first)) : 1];
}

/** Whether a PNG or a JPEG ends as its kind does, whatever follows it; browsers show a part of one that was cut
 * short. */
export function whole(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 8;
  if (text(bytes, 1, 3) === "PNG") {
    while (at + 12 <= bytes.length && text(bytes, at + 4, 4) !== "IEND") at += 12 + view.getUint32(at);
    return at + 12 <= bytes.length;
  }
  if (text(bytes, 0, 2) !== "\xff\xd8") return true;
  at = 2;
  while (at + 4 < bytes.length && bytes[at + 1] !== 0xda) at += bytes[at + 1] === 0xff ? 1 : 2 + view.getUint16(at + 2);
  for (at = bytes.indexOf(0xff, at + 2); at >= 0; at = bytes.indexOf(0xff, at + 1))
    if (bytes[at + 1] === 0xd9) return true;
  return false;
}

/** The mean of `by` × `by` pixels each, as Pillow's Image.reduce has it; the last ones may be of fewer. */
export function reduced({ pixels, width, height }, by) {
  if (by === 1) return { pixels, width, height };
  const wide = Math.ceil(width / by);
  const high = Math.ceil(height / by);
  const out = new Uint8Array(3 * wide * high);
  for (let y = 0, to = 0; y < high; y++) {
    for (let x = 0; x < wide; x++) {
      const right = Math.min(width, (x + 1) * by);
      const bottom = Math.min(height, (y + 1) * by);
      const count = (right - x * by) * (bottom - y * by);
      const share = Math.trunc(Math.fround(2 ** 32 / (256 * count)));
      for (let c = 0; c < 3; c++) {
        let sum = Math.trunc(count / 2);
        for (let row = y * by; row < bottom; row++)
          for (let at = row * width + x * by; at < row * width + right; at++) sum += pixels[3 * at + c];
        out[to++] = Math.floor((sum * share) / 2 ** 24);
      }
    }
  }
  return { pixels: out, width: wide, height: high };
}

/** The pixels of a bitmap over white, strip by strip, their sides divided by `by`. */
function pixelsOf(bitmap, by) {
  const { width, height } = bitmap;
  const step = by * Math.max(1, Math.floor(STRIP_PIXELS / (width * by)));
  const brush = drawingOn(new OffscreenCanvas(width, Math.min(step, height)), { willReadFrequently: true });
  brush.fillStyle = "white";
  const [wide, tall] = [Math.ceil(width / by), Math.ceil(height / by)];
  const out = { pixels: new Uint8Array(3 * wide * tall), width: wide, height: tall };
  for (let top = 0; top < height; top += step) {
    const high = Math.min(step, height - top);
    brush.fillRect(0, 0, width, high);
    brush.drawImage(bitmap, 0, -top);
    const { data } = brush.getImageData(0, 0, width, high);
    const pixels = new Uint8Array(3 * width * high);
    for (let at = 0; at < pixels.length; at++) pixels[at] = data[at + Math.floor(at / 3)];
    out.pixels.set(reduced({ pixels, width, height: high }, by).pixels, (3 * wide * top) / by);
  }
  return out;
}

/** {pixels RGB, width, height} of a file's bytes, upright, and `full`, its size before; a Refused otherwise. */
export async function decoded(bytes, name = "the image") {
  if (text(bytes, 8, 8) === "WEBPVP8X" && bytes[20] & 8)
    throw new Refused(`'${name}' is a WebP with EXIF, which browsers turn differently; save it as PNG or JPEG.`);
  const options = /** @type {ImageBitmapOptions} */ ({ colorSpaceConversion: "none", imageOrientation: "from-image" });
  const bitmap = whole(bytes) && (await createImageBitmap(new Blob([bytes]), options).catch(() => null));
  if (!bitmap) throw new Refused(`'${name}' ${UNREAD}`);
  const { width, height } = bitmap;
  const isJpeg = text(bytes, 0, 2) === "\xff\xd8";
  const most = isJpeg ? MOST_PIXELS : PLAIN_PIXELS;
  if (width * height > most)
    throw new Refused(`'${name}' has more than ${most / 1e6} megapixels; scale it down and try again.`);
  if (Math.min(width, height) < LEAST_SIDE)
    throw new Refused(
      `'${name}' is ${width} × ${height} pixels; a side needs ${LEAST_SIDE} or more for a surface to be seen.`,
    );
  const [first, second] = factors(isJpeg, width, height);
  const picture = reduced(pixelsOf(bitmap, first), second);
  bitmap.close();
  return { ...picture, full: [width, height] };
}
