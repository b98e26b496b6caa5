/** An uncompressed zip; pictures are compressed already. No DOM here. */

import { save } from "../shared/save.js";

/** The checksum of each file in a zip. @param {Uint8Array} bytes */
export function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = (crc >>> 1) ^ (crc & 1 && 0xedb88320);
  }
  return (crc ^ 0xffffffff) >>> 0;
}

const UTF8 = 0x0800; // names are UTF-8
const DAY = 0x21; // 1 January 1980, so that no visitor's time is stored

/** Numbers of so many bytes, the lowest byte first. @param {2 | 4} size @param {number[]} values */
const numbers = (size, ...values) =>
  Uint8Array.from(values.flatMap((value) => Array.from({ length: size }, (_, i) => value >>> (8 * i))));

/** @param {number[]} codes */
const mark = (...codes) => Uint8Array.of(0x50, 0x4b, ...codes);

/** @param {Uint8Array[]} parts */
const length = (parts) => parts.reduce((sum, part) => sum + part.length, 0);

/** The parts of a zip, for a Blob. @param {[name: string, bytes: Uint8Array][]} files */
export function zipped(files) {
  const body = [];
  const directory = [];
  let offset = 0;
  for (const [text, bytes] of files) {
    const name = new TextEncoder().encode(text);
    const sizes = numbers(4, crc32(bytes), bytes.length, bytes.length);
    const both = [numbers(2, 20, UTF8, 0, 0, DAY), sizes, numbers(2, name.length, 0)]; // in both headers of a file
    const local = [mark(3, 4), ...both, name, bytes];
    directory.push(mark(1, 2), numbers(2, 20), ...both, numbers(2, 0, 0, 0), numbers(4, 0, offset), name);
    body.push(...local);
    offset += length(local);
  }
  const counts = numbers(2, 0, 0, files.length, files.length);
  return [...body, ...directory, mark(5, 6), counts, numbers(4, length(directory), offset), numbers(2, 0)];
}

/** @param {Blob} blob */
export const contentOf = async (blob) => new Uint8Array(await blob.arrayBuffer());

/** @param {string} name @param {[string, Uint8Array][]} files */
export const saveZip = (name, files) =>
  save(name, new Blob(/** @type {BlobPart[]} */ (zipped(files)), { type: "application/zip" }));
