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

/** name -> {shape, values}, and `__metadata__`; a Refused for a file that is none. */
export function tensors(buffer, name = "the file") {
  try {
    const size = Number(new DataView(buffer).getBigUint64(0, true));
    const { __metadata__, ...listed } = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, size)));
    const read = ({ dtype, shape, data_offsets: [start, end] }) => {
      const values = READ[dtype](buffer.slice(8 + size + start, 8 + size + end));
      if (values.length !== shape.reduce((a, b) => a * b, 1)) throw new RangeError("cut short");
      return { shape, values };
    };
    return { __metadata__, ...Object.fromEntries(Object.entries(listed).map(([key, one]) => [key, read(one)])) };
  } catch {
    throw new Refused(`'${name}' cannot be read as a file of numbers; make it again.`);
  }
}

/** The bytes of a file of float32 vectors, each aligned. */
export function written(vectors, metadata) {
  const listed = { __metadata__: metadata };
  let end = 0;
  for (const [name, { length }] of Object.entries(vectors))
    listed[name] = { dtype: "F32", shape: [length], data_offsets: [end, (end += 4 * length)] };
  const head = new TextEncoder().encode(JSON.stringify(listed));
  const size = head.length + 7 - ((head.length + 7) % 8);
  const out = new Uint8Array(8 + size + end);
  new DataView(out.buffer).setBigUint64(0, BigInt(size), true);
  out.fill(0x20, 8).set(head, 8); // spaces
  const values = new Float32Array(out.buffer, 8 + size);
  for (const [name, vector] of Object.entries(vectors)) values.set(vector, listed[name].data_offsets[0] / 4);
  return out;
}

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

export const sum = (values) => values.reduce((total, value) => total + value, 0);
export const mean = (values) => sum(values) / values.length;
export const best = (row) => row.reduce((top, value, i) => (value > row[top] ? i : top), 0);
export const rounded = (row, digits = 6) => Array.from(row, (value) => Number(value.toFixed(digits)));
