/** A visitor's file to upright pixels RGB, by the browser's decoders, within the limits of the server. */

import { drawingOn } from "../shared/canvas.js";
import { Refused } from "./refusal.js";
import { reduced } from "./resize.js";

export const MOST_BYTES = 20e6;
const MOST_PIXELS = 64e6; // of a JPEG
const PLAIN_PIXELS = 24e6; // of other kinds
const SHORT_SIDE = 1024; // lower limit of a reduced picture
const REDUCED_PIXELS = 6e6; // upper limit of it
const LEAST_SIDE = 8;
const STRIP_PIXELS = 1e6;
const REMEDY = "save it as PNG or JPEG and try again";

const text = (bytes, at, length) => String.fromCharCode(...bytes.subarray(at, at + length));

/** The size in the first frame of a JPEG. */
function sizeOfJpeg(view) {
  for (let at = 2; at + 9 < view.byteLength; ) {
    const mark = view.getUint8(at + 1);
    if (view.getUint8(at) !== 0xff) return null;
    if (mark === 0xff) at += 1;
    else if (mark >= 0xc0 && mark <= 0xcf && ![0xc4, 0xc8, 0xcc].includes(mark))
      return [view.getUint16(at + 7), view.getUint16(at + 5)];
    else at += 2 + view.getUint16(at + 2);
  }
  return null;
}

function sizeOfWebp(bytes, view) {
  const first = text(bytes, 12, 4);
  const three = (at) => 1 + bytes[at] + 256 * bytes[at + 1] + 65536 * bytes[at + 2];
  if (first === "VP8X") return [three(24), three(27)];
  if (first === "VP8L") {
    const packed = view.getUint32(21, true);
    return [1 + (packed & 0x3fff), 1 + ((packed >> 14) & 0x3fff)];
  }
  return [view.getUint16(26, true) & 0x3fff, view.getUint16(28, true) & 0x3fff];
}

/** {kind, width, height} from the first bytes; null for an unknown kind. */
export function headerOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const sized = (kind, size) => ({ kind, width: size?.[0] ?? 0, height: size?.[1] ?? 0 });
  if (text(bytes, 0, 8) === "\x89PNG\r\n\x1a\n") return sized("PNG", [view.getUint32(16), view.getUint32(20)]);
  if (text(bytes, 0, 3) === "\xff\xd8\xff") return sized("JPEG", sizeOfJpeg(view));
  if (/^GIF8[79]a/.test(text(bytes, 0, 6))) return sized("GIF", [view.getUint16(6, true), view.getUint16(8, true)]);
  if (text(bytes, 0, 2) === "BM") return sized("BMP", [view.getInt32(18, true), view.getInt32(22, true)].map(Math.abs));
  if (text(bytes, 0, 4) === "RIFF" && text(bytes, 8, 4) === "WEBP") return sized("WEBP", sizeOfWebp(bytes, view));
  if (/^(II[*+]\0|MM\0[*+])/.test(text(bytes, 0, 4))) return sized("TIFF");
  return null;
}

/** The integer by which the sides of a picture are divided. */
export function factor(width, height) {
  const short = Math.min(width, height);
  let found = Math.max(1, Math.floor(short / SHORT_SIDE));
  while (width * height > REDUCED_PIXELS * found ** 2 && Math.floor(short / (found + 1)) >= LEAST_SIDE) found += 1;
  return found;
}

/** The factors one after the other: a JPEG is first made smaller by 2, 4 or 8. */
export function factors(kind, width, height) {
  if (kind !== "JPEG") return [factor(width, height)];
  const wanted = factor(width, height);
  const first = [8, 4, 2].find((scale) => scale <= wanted) ?? 1;
  return [first, factor(Math.ceil(width / first), Math.ceil(height / first))];
}

function checked(bytes, name) {
  if (!bytes.length) throw new Refused(`'${name}' is empty (0 bytes); copy or save the image again.`);
  if (bytes.length > MOST_BYTES)
    throw new Refused(`The image is larger than ${MOST_BYTES / 1e6} MB; scale it down and try again.`);
  let found;
  try {
    found = headerOf(bytes);
  } catch {
    throw new Refused(`'${name}' is cut short or damaged; ${REMEDY}.`);
  }
  if (!found) throw new Refused(`'${name}' is not an image of a known kind; ${REMEDY}.`);
  const { kind, width, height } = found;
  if (kind === "TIFF") throw new Refused(`'${name}' is a TIFF file, which browsers do not read; ${REMEDY}.`);
  if (!width || !height) throw new Refused(`'${name}' is cut short or damaged; ${REMEDY}.`);
  const most = kind === "JPEG" ? MOST_PIXELS : PLAIN_PIXELS;
  if (width * height > most)
    throw new Refused(
      `'${name}' is ${width} × ${height} pixels; a ${kind} file is read up to ${most / 1e6} megapixels here. Scale it down and try again.`,
    );
  if (Math.min(width, height) < LEAST_SIDE)
    throw new Refused(
      `'${name}' is ${width} × ${height} pixels; a side needs ${LEAST_SIDE} or more for a surface to be seen, so choose a larger image.`,
    );
  return found;
}

/** Whether the picture ends as its kind does, whatever follows it; browsers show a part of one that was cut short. */
export function whole(bytes, kind) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = kind === "PNG" ? 8 : 2;
  if (kind === "PNG") {
    while (at + 12 <= bytes.length && text(bytes, at + 4, 4) !== "IEND") at += 12 + view.getUint32(at);
    return at + 12 <= bytes.length;
  }
  if (kind !== "JPEG") return true;
  while (at + 4 < bytes.length && bytes[at + 1] !== 0xda) at += bytes[at + 1] === 0xff ? 1 : 2 + view.getUint16(at + 2);
  for (at = bytes.indexOf(0xff, at + 2); at >= 0; at = bytes.indexOf(0xff, at + 1))
    if (bytes[at + 1] === 0xd9) return true;
  return false;
}

/** The orientation in an EXIF table, 1 to 8. */
export function rotation(exif) {
  const start = text(exif, 0, 6) === "Exif\0\0" ? 6 : 0;
  const view = new DataView(exif.buffer, exif.byteOffset + start, exif.byteLength - start);
  const little = view.getUint16(0) === 0x4949;
  const at = view.getUint32(4, little);
  for (let entry = 0; entry < Math.min(512, view.getUint16(at, little)); entry++) {
    const place = at + 2 + 12 * entry;
    if (view.getUint16(place, little) !== 0x0112) continue;
    const turn = view.getUint16(place + 8, little);
    return turn >= 1 && turn <= 8 ? turn : 1;
  }
  return 1;
}

/** A WebP without its EXIF, which browsers treat differently, and its orientation. */
export function bare(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  for (let at = 12; at + 8 <= bytes.length; ) {
    const size = view.getUint32(at + 4, true);
    if (text(bytes, at, 4) === "EXIF") {
      const copy = bytes.slice();
      copy.set([0x2d, 0x2d, 0x2d, 0x2d], at);
      try {
        return { bytes: copy, turn: rotation(bytes.subarray(at + 8, at + 8 + size)) };
      } catch {
        return { bytes: copy, turn: 1 }; // damaged EXIF does not mean damaged pixels
      }
    }
    at += 8 + size + (size % 2);
  }
  return { bytes, turn: 1 };
}

/** The picture turned upright, from an orientation of EXIF. */
export function upright({ pixels, width, height }, turn) {
  if (turn === 1) return { pixels, width, height };
  const [across, mirrored, upside] = [turn > 4, [2, 3, 7, 8].includes(turn), [3, 4, 6, 7].includes(turn)];
  const [wide, high] = across ? [height, width] : [width, height];
  const out = new Uint8ClampedArray(pixels.length);
  for (let y = 0; y < high; y++)
    for (let x = 0; x < wide; x++) {
      let [column, row] = across ? [y, x] : [x, y];
      if (mirrored) column = width - 1 - column;
      if (upside) row = height - 1 - row;
      const from = 3 * (row * width + column);
      out.set(pixels.subarray(from, from + 3), 3 * (y * wide + x));
    }
  return { pixels: out, width: wide, height: high };
}

/** The pixels of a bitmap over white, strip by strip, their sides divided by `by`. */
function pixelsOf(bitmap, by) {
  const { width, height } = bitmap;
  const step = by * Math.max(1, Math.floor(STRIP_PIXELS / (width * by)));
  const canvas = new OffscreenCanvas(width, Math.min(step, height));
  const brush = drawingOn(canvas, { willReadFrequently: true });
  const wide = Math.ceil(width / by);
  const out = {
    pixels: new Uint8ClampedArray(3 * wide * Math.ceil(height / by)),
    width: wide,
    height: Math.ceil(height / by),
  };
  for (let top = 0, to = 0; top < height; top += step) {
    const high = Math.min(step, height - top);
    brush.fillStyle = "white";
    brush.fillRect(0, 0, width, high);
    brush.drawImage(bitmap, 0, -top);
    const { data } = brush.getImageData(0, 0, width, high);
    const pixels = new Uint8ClampedArray(3 * width * high);
    for (let from = 0, at = 0; from < data.length; from += 4) {
      pixels[at++] = data[from];
      pixels[at++] = data[from + 1];
      pixels[at++] = data[from + 2];
    }
    const small = reduced({ pixels, width, height: high }, by);
    out.pixels.set(small.pixels, to);
    to += small.pixels.length;
  }
  return out;
}

/** {pixels RGB, width, height} of a file's bytes, upright, and `full`, its size before; a Refused otherwise. */
export async function decoded(bytes, name = "the image") {
  const { kind } = checked(bytes, name);
  const { bytes: plain, turn } = kind === "WEBP" ? bare(bytes) : { bytes, turn: 1 };
  /** @type {ImageBitmap} */
  let bitmap;
  try {
    if (!whole(bytes, kind)) throw new RangeError("cut short");
    const options = /** @type {ImageBitmapOptions} */ ({
      colorSpaceConversion: "none",
      imageOrientation: "from-image",
    });
    bitmap = await createImageBitmap(new Blob([plain]), options);
  } catch {
    throw new Refused(`'${name}' is cut short or damaged; ${REMEDY}.`);
  }
  const [first, second = 1] = factors(kind, bitmap.width, bitmap.height);
  const picture = upright(reduced(pixelsOf(bitmap, first), second), turn);
  const full = turn > 4 ? [bitmap.height, bitmap.width] : [bitmap.width, bitmap.height];
  bitmap.close();
  return { ...picture, full };
}
