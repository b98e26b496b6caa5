/** A QR code of a text, level L: ISO/IEC 18004, byte mode, versions 1 to 20, mask 0. No DOM here. */

// of each version: check bytes of a block, and the number of blocks
const CHECKS = [7, 10, 15, 20, 26, 18, 20, 24, 30, 18, 20, 24, 26, 30, 22, 24, 28, 30, 28, 28];
const BLOCKS = [1, 1, 1, 1, 1, 2, 2, 2, 2, 4, 4, 4, 4, 4, 6, 6, 6, 6, 7, 8];
const [POWERS, LOGS] = [new Uint8Array(510), new Uint8Array(256)];
for (let i = 0, x = 1; i < 255; i++, x = (x << 1) ^ (x > 127 ? 0x11d : 0)) {
  POWERS[i] = POWERS[i + 255] = x;
  LOGS[x] = i;
}
const times = (a, b) => (a && b ? POWERS[LOGS[a] + LOGS[b]] : 0);

/** The check bytes of a block: the remainder of its polynomial over GF(256). */
export function checks(block, count) {
  let divisor = [1];
  for (let i = 0; i < count; i++)
    divisor = [...divisor, 0].map((one, k) => one ^ (k ? times(divisor[k - 1], POWERS[i]) : 0));
  const rest = [...block, ...new Array(count).fill(0)];
  for (let at = 0; at < block.length; at++) {
    const lead = rest[at];
    for (let k = 0; k <= count; k++) rest[at + k] ^= times(divisor[k], lead);
  }
  return rest.slice(block.length);
}

/** The remainder of a number's bits, for format and version. */
function remainder(value, bits, divisor) {
  let rest = value << bits;
  const top = 31 - Math.clz32(divisor);
  while (rest >= 1 << top) rest ^= divisor << (31 - Math.clz32(rest) - top);
  return (value << bits) | rest;
}

const alignments = (version) => Math.floor(version / 7) + 2;

function capacity(version) {
  const n = alignments(version);
  const free = (16 * version + 128) * version + 64;
  return (free - (version > 1 ? (25 * n - 10) * n - 55 : 0) - (version > 6 ? 36 : 0)) >> 3;
}

/** All bytes of a version: the text, padding and checks, interleaved. */
function codewords(bytes, version) {
  const [count, blocks, all] = [CHECKS[version - 1], BLOCKS[version - 1], capacity(version)];
  const length = [bytes.length >> 8, bytes.length & 255].slice(version < 10 ? 1 : 0);
  const nibbles = [4, ...[...length, ...bytes].flatMap((byte) => [byte >> 4, byte & 15]), 0];
  const data = [];
  for (let i = 0; i < nibbles.length; i += 2) data.push((nibbles[i] << 4) | (nibbles[i + 1] ?? 0));
  for (let i = 0; data.length < all - count * blocks; i++) data.push([0xec, 0x11][i % 2]);
  const short = Math.floor(data.length / blocks);
  const shorter = blocks - (data.length % blocks);
  const own = Array.from({ length: blocks }, (_, i) => {
    const start = i * short + Math.max(0, i - shorter);
    return data.slice(start, start + short + (i < shorter ? 0 : 1));
  });
  const tails = own.map((block) => checks(block, count));
  const woven = (rows) => Array.from({ length: short + 1 }, (_, i) => rows.map((row) => row[i])).flat();
  return [...woven(own), ...Array.from({ length: count }, (_, i) => tails.map((tail) => tail[i])).flat()].filter(
    (byte) => byte !== undefined,
  );
}

/** Draw what is the same for every text; returns the cells that are taken. */
function frame(cells, version) {
  const size = cells.length;
  const taken = cells.map((row) => row.map(() => false));
  const set = (x, y, dark) => {
    if (x < 0 || y < 0 || x >= size || y >= size) return;
    cells[y][x] = Boolean(dark);
    taken[y][x] = true;
  };
  const square = (cx, cy, reach, light) => {
    for (let y = -reach; y <= reach; y++)
      for (let x = -reach; x <= reach; x++) {
        const ring = Math.max(Math.abs(x), Math.abs(y));
        set(cx + x, cy + y, !light.includes(ring));
      }
  };
  for (let i = 0; i < size; i++) {
    set(6, i, i % 2 === 0);
    set(i, 6, i % 2 === 0);
  }
  for (const [x, y] of [
    [3, 3],
    [size - 4, 3],
    [3, size - 4],
  ])
    square(x, y, 4, [2, 4]);
  const n = alignments(version);
  const step = 2 * Math.ceil((4 * version + 4) / (2 * n - 2));
  const at = version > 1 ? [6, ...Array.from({ length: n - 1 }, (_, i) => size - 7 - (n - 2 - i) * step)] : [];
  const corner = (x, y) => (x === 6 || y === 6) && [6, at.at(-1)].includes(x) && [6, at.at(-1)].includes(y);
  for (const x of at) for (const y of at) if (!corner(x, y)) square(x, y, 2, [1]);
  const format = remainder(0b01000, 10, 0x537) ^ 0x5412;
  for (let i = 0; i < 15; i++) {
    const bit = (format >> i) & 1;
    set(8, i < 6 ? i : i < 8 ? i + 1 : size - 15 + i, bit);
    set(i < 8 ? size - 1 - i : i === 8 ? 7 : 14 - i, 8, bit);
  }
  set(8, size - 8, 1);
  const number = remainder(version, 12, 0x1f25);
  for (let i = 0; version > 6 && i < 18; i++) {
    const [a, b] = [size - 11 + (i % 3), Math.floor(i / 3)];
    set(a, b, (number >> i) & 1);
    set(b, a, (number >> i) & 1);
  }
  return taken;
}

/** Rows of cells, true for dark; null for a text that is too long. */
export function qr(text) {
  const bytes = [...new TextEncoder().encode(text)];
  const room = (version) => capacity(version) - CHECKS[version - 1] * BLOCKS[version - 1] - (version < 10 ? 2 : 3);
  const version = CHECKS.findIndex((_, i) => room(i + 1) >= bytes.length) + 1;
  if (!version) return null;
  const size = 17 + 4 * version;
  const cells = Array.from({ length: size }, () => new Array(size).fill(false));
  const taken = frame(cells, version);
  const bits = codewords(bytes, version).flatMap((byte) => [7, 6, 5, 4, 3, 2, 1, 0].map((k) => (byte >> k) & 1));
  let next = 0;
  let up = true;
  for (let right = size - 1; right > 0; right -= 2, up = !up) {
    if (right === 6) right = 5; // a column of its own
    for (let i = 0; i < size; i++) {
      const y = up ? size - 1 - i : i;
      for (const x of [right, right - 1])
        if (!taken[y][x]) cells[y][x] = Boolean((bits[next++] ?? 0) ^ Number((x + y) % 2 === 0));
    }
  }
  return cells;
}

/** The code as SVG with its quiet border; "" for a text that is too long. */
export function qrSvg(text) {
  const cells = qr(text);
  if (!cells) return "";
  const size = cells.length + 8;
  const dark = cells.flatMap((row, y) => row.map((one, x) => (one ? `M${x + 4} ${y + 4}h1v1h-1z` : "")));
  return `<svg viewBox="0 0 ${size} ${size}" role="img" aria-label="QR code of the link" shape-rendering="crispEdges"><rect width="${size}" height="${size}" fill="#fff"/><path d="${dark.join("")}"/></svg>`;
}
