/** A visitor's file to upright pixels RGB, by the browser's decoders, within the limits of the server. */

import { drawingOn } from "../shared/canvas.js";
import { Refusal } from "../shared/refusal.js";

const UNREAD =
  "is no picture that this browser reads, or is cut short or damaged; save it as PNG or JPEG and try again.";
const WIDEST = 4; // sides of a picture: the longest is at most this many times `large`

/** @param {Uint8Array} bytes @param {number} at @param {number} length */
const text = (bytes, at, length) => String.fromCharCode(...bytes.subarray(at, at + length));
/** @param {Uint8Array} bytes */
const isJpeg = (bytes) => text(bytes, 0, 2) === "\xff\xd8";

/** Return whether a PNG or a JPEG ends as its kind does, whatever follows it; browsers show a part of one that was cut
 * short.
 * @param {Uint8Array} bytes */
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

/** Return a bitmap over white at a share of its size. @param {ImageBitmap} bitmap @param {number} scale */
function drawn(bitmap, scale) {
  const side = (/** @type {number} */ length) => Math.max(1, Math.round(scale * length));
  const canvas = new OffscreenCanvas(side(bitmap.width), side(bitmap.height));
  const brush = drawingOn(canvas, { willReadFrequently: true });
  Object.assign(brush, { fillStyle: "white", imageSmoothingQuality: "high" });
  brush.fillRect(0, 0, canvas.width, canvas.height);
  brush.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  return { canvas, brush };
}

/** Return a picture of a file's bytes: its size, its pixels (a large picture is drawn smaller), and a small copy as a
 * data address; a Refusal otherwise.
 * @param {Uint8Array} bytes @param {string} name @param {SiteRules} rules */
export async function decoded(bytes, name, { pixels, side }) {
  if (text(bytes, 8, 8) === "WEBPVP8X" && bytes[20] & 8)
    throw new Refusal(`'${name}' is a WebP with EXIF, which browsers turn differently; save it as PNG or JPEG.`);
  const options = /** @type {ImageBitmapOptions} */ ({ colorSpaceConversion: "none", imageOrientation: "from-image" });
  const file = new Blob([/** @type {any} */ (bytes)]);
  const bitmap = whole(bytes) && (await createImageBitmap(file, options).catch(() => null));
  if (!bitmap) throw new Refusal(`'${name}' ${UNREAD}`);
  const { width, height } = bitmap;
  const most = isJpeg(bytes) ? pixels.jpeg : pixels.other;
  if (width * height > most)
    throw new Refusal(`'${name}' has more than ${most / 1e6} megapixels; scale it down and try again.`);
  const [short, long] = [Math.min(width, height), Math.max(width, height)];
  if (short < side.least)
    throw new Refusal(
      `'${name}' is ${width} × ${height} pixels; a side needs ${side.least} or more for a surface to be seen.`,
    );
  const { canvas, brush } = drawn(bitmap, Math.min(1, side.large / short, (WIDEST * side.large) / long));
  const { data } = brush.getImageData(0, 0, canvas.width, canvas.height);
  const preview = await drawn(bitmap, Math.min(1, side.preview / long)).canvas.convertToBlob({
    type: "image/jpeg",
    quality: 0.85,
  });
  bitmap.close();
  return {
    ...{ width, height },
    raster: { pixels: Uint8Array.from(data.filter((_, at) => at % 4 < 3)), width: canvas.width, height: canvas.height },
    preview: new /** @type {any} */ (self).FileReaderSync().readAsDataURL(preview),
  };
}
