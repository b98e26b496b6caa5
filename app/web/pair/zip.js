/** An uncompressed zip; pictures are compressed already. No DOM here. */

const TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let bit = 0; bit < 8; bit++) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});

/** The checksum of each file in a zip. */
export function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = TABLE[(crc ^ byte) & 255] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

const UTF8 = 0x0800; // names are UTF-8
const DAY = 0x21; // 1 January 1980, so that no visitor's time is stored

/** The common part of both headers of a file. */
function shared({ bytes, name, crc }) {
  const view = new DataView(new ArrayBuffer(26));
  [20, UTF8, 0, 0, DAY].forEach((value, i) => view.setUint16(2 * i, value, true));
  [crc, bytes.length, bytes.length].forEach((value, i) => view.setUint32(10 + 4 * i, value, true));
  view.setUint16(22, name.length, true);
  return new Uint8Array(view.buffer);
}

const mark = (...codes) => Uint8Array.of(0x50, 0x4b, ...codes);

function central(file, offset) {
  const rest = new DataView(new ArrayBuffer(14));
  rest.setUint32(10, offset, true);
  return [mark(1, 2), Uint8Array.of(20, 0), shared(file), new Uint8Array(rest.buffer), file.name];
}

function ending(count, size, offset) {
  const view = new DataView(new ArrayBuffer(18));
  view.setUint16(4, count, true);
  view.setUint16(6, count, true);
  view.setUint32(8, size, true);
  view.setUint32(12, offset, true);
  return [mark(5, 6), new Uint8Array(view.buffer)];
}

const length = (parts) => parts.reduce((sum, part) => sum + part.length, 0);

/** files: [[name, Uint8Array]]; returns the parts of a zip, for a Blob. */
export function zipped(files) {
  const body = [];
  const directory = [];
  let offset = 0;
  for (const [text, bytes] of files) {
    const file = { bytes, name: new TextEncoder().encode(text), crc: crc32(bytes) };
    const local = [mark(3, 4), shared(file), file.name, bytes];
    directory.push(...central(file, offset));
    body.push(...local);
    offset += length(local);
  }
  return [...body, ...directory, ...ending(files.length, length(directory), offset)];
}
