/** Files of numbers: reading and writing `.safetensors`. No DOM here. */

import { Refused } from "./refusal.js";

/** Half precision, as an array of 65,536 floats by their bits. */
/** @type {Float32Array | null} */
let halves = null;
function table() {
  return (halves ??= Float32Array.from({ length: 65536 }, (_, bits) => {
    const [sign, power, rest] = [bits >> 15 ? -1 : 1, (bits >> 10) & 31, bits & 1023];
    if (power === 31) return rest ? Number.NaN : sign * Number.POSITIVE_INFINITY;
    return sign * (power ? 2 ** (power - 15) * (1 + rest / 1024) : 2 ** -24 * rest);
  }));
}

const READ = {
  F32: (bytes) => new Float32Array(bytes),
  F16: (bytes) => Float32Array.from(new Uint16Array(bytes), (bits) => table()[bits]),
  I64: (bytes) => Float64Array.from(new BigInt64Array(bytes), Number),
};

/** name -> {dtype, shape, bytes}, and `__metadata__`; a Refused for a file that is none. */
export function raw(buffer, name = "the file") {
  try {
    const size = Number(new DataView(buffer).getBigUint64(0, true));
    const listed = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, size)));
    for (const [key, one] of Object.entries(listed)) {
      if (key === "__metadata__") continue;
      const [start, end] = one.data_offsets;
      listed[key] = {
        dtype: one.dtype,
        shape: one.shape,
        bytes: new Uint8Array(buffer, 8 + size + start, end - start),
      };
    }
    return listed;
  } catch {
    throw new Refused(`'${name}' cannot be read as a file of numbers; make it again.`);
  }
}

/** name -> {shape, values}, and `__metadata__`. */
export function tensors(buffer, name = "the file") {
  const found = raw(buffer, name);
  for (const [key, { dtype, shape, bytes }] of Object.entries(found)) {
    if (key === "__metadata__") continue;
    const values = READ[dtype]?.(bytes.slice().buffer);
    if (values?.length !== shape.reduce((a, b) => a * b, 1))
      throw new Refused(`'${name}' cannot be read as a file of numbers; make it again.`);
    found[key] = { shape, values };
  }
  return found;
}

export const floats = (values, shape) => ({
  dtype: "F32",
  shape,
  bytes: new Uint8Array(Float32Array.from(values).buffer),
});
export const wholes = (values) => ({
  dtype: "I64",
  shape: [values.length],
  bytes: new Uint8Array(BigInt64Array.from(values, BigInt).buffer),
});
const WIDTHS = { F64: 8, I64: 8, F32: 4, F16: 2 };

/** The bytes of a file of entries {dtype, shape, bytes}; the widest come first, so that each is aligned. */
export function file(entries, metadata) {
  const { __metadata__: _, ...all } = entries;
  const names = Object.keys(all).sort((a, b) => (WIDTHS[all[b].dtype] ?? 1) - (WIDTHS[all[a].dtype] ?? 1));
  const listed = { __metadata__: metadata };
  let end = 0;
  for (const name of names) {
    const { dtype, shape, bytes } = all[name];
    listed[name] = { dtype, shape, data_offsets: [end, (end += bytes.length)] };
  }
  let head = new TextEncoder().encode(JSON.stringify(listed));
  head = new TextEncoder().encode(JSON.stringify(listed) + " ".repeat((8 - (head.length % 8)) % 8));
  const out = new Uint8Array(8 + head.length + end);
  new DataView(out.buffer).setBigUint64(0, BigInt(head.length), true);
  out.set(head, 8);
  for (const name of names) out.set(all[name].bytes, 8 + head.length + listed[name].data_offsets[0]);
  return out;
}

/** The bytes of a file of float32 vectors. */
export const written = (vectors, metadata) =>
  file(
    Object.fromEntries(Object.entries(vectors).map(([name, values]) => [name, floats(values, [values.length])])),
    metadata,
  );

/** Rows of a matrix {shape: [N, W], values}. */
export const rowOf = ({ shape, values }, row) => values.subarray(row * shape[1], (row + 1) * shape[1]);

export function dot(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += a[i] * b[i];
  return sum;
}

export const norm = (row) => Math.sqrt(dot(row, row));

export function unit(row) {
  const length = norm(row) || 1;
  return Float64Array.from(row, (value) => value / length);
}

export function softmax(row) {
  const top = Math.max(...row);
  const shares = Array.from(row, (value) => Math.exp(value - top));
  const sum = shares.reduce((a, b) => a + b, 0);
  return shares.map((value) => value / sum);
}

export const best = (row) => row.reduce((top, value, i) => (value > row[top] ? i : top), 0);
export const rounded = (row, digits = 6) => Array.from(row, (value) => Number(value.toFixed(digits)));
