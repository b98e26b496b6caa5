/** Files of numbers, `.safetensors`, and sums of rows. No DOM here. */

import { Refusal } from "../shared/refusal.js";

const HALVES = Float32Array.from({ length: 65536 }, (_, bits) => {
  const [sign, power, rest] = [bits >> 15 ? -1 : 1, (bits >> 10) & 31, bits & 1023];
  return sign * (power ? 2 ** (power - 15) * (1 + rest / 1024) : 2 ** -24 * rest);
});
/** @type {Record<string, (bytes: ArrayBuffer) => ArrayLike<number>>} */
const READ = {
  F32: (bytes) => new Float32Array(bytes),
  F16: (bytes) => Float32Array.from(new Uint16Array(bytes), (bits) => HALVES[bits]),
  I64: (bytes) => Float64Array.from(new BigInt64Array(bytes), Number),
};

/** name -> {dtype, shape, values}, and `__metadata__`; a Refusal for a file that is none.
 * @param {ArrayBuffer} buffer @returns {Record<string, any>} */
export function tensors(buffer, name = "the file") {
  try {
    const size = Number(new DataView(buffer).getBigUint64(0, true));
    const { __metadata__, ...listed } = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, size)));
    for (const [key, { dtype, shape, data_offsets }] of Object.entries(listed)) {
      const [start, end] = data_offsets;
      const values = READ[dtype](buffer.slice(8 + size + start, 8 + size + end));
      if (values.length !== shape.reduce((/** @type {number} */ a, /** @type {number} */ b) => a * b, 1)) throw 0;
      listed[key] = { dtype, shape, values };
    }
    return { __metadata__, ...listed };
  } catch {
    throw new Refusal(`'${name}' cannot be read as a file of numbers; make it again.`);
  }
}

/** Return a number or a vector as a tensor. @param {Tensor | Floats | number} given @returns {Tensor} */
export function tensorOf(given) {
  if (typeof given === "number") return { values: Float64Array.of(given), shape: [] };
  return "shape" in given ? given : { values: given, shape: [given.length] };
}

/** Return vectors of one length as the rows of a tensor. @param {ArrayLike<number>[]} rows @returns {Tensor} */
export function stacked(rows) {
  const values = new Float32Array(rows.length * rows[0].length);
  for (const [i, row] of rows.entries()) values.set(row, i * row.length);
  return { values, shape: [rows.length, rows[0].length] };
}

/** Return rows of a tensor of rows, whatever is around them. @type {(rows: Tensor, row: number) => Float32Array} */
export const rowOf = ({ shape, values }, row) => {
  const width = shape[shape.length - 1];
  return values.subarray(row * width, (row + 1) * width);
};

/** Return all rows of a tensor. @param {Tensor} rows @returns {Float32Array[]} */
export const rowsOf = (rows) => Array.from({ length: rows.shape.at(-2) ?? 1 }, (_, row) => rowOf(rows, row));

/** @param {ArrayLike<number>} a @param {ArrayLike<number>} b */
export function dot(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += a[i] * b[i];
  return sum;
}

/** @param {ArrayLike<number>} row */
export const norm = (row) => Math.sqrt(dot(row, row));

/** @param {ArrayLike<number>} row */
export function unit(row) {
  const length = norm(row) || 1;
  return Float64Array.from(row, (value) => value / length);
}

/** Return the unit rows nearest to another one, the nearest first.
 * @param {Floats[]} rows @param {Floats} query
 * @param {number} count @param {number} except a row that is left out */
export function nearest(rows, query, count, except = -1) {
  const all = rows.map((row, point) => ({ point, cosine: dot(query, row) }));
  const others = all.filter(({ point }) => point !== except);
  return others.sort((a, b) => b.cosine - a.cosine).slice(0, count);
}

/** @param {number[]} values */
export const sum = (values) => values.reduce((total, value) => total + value, 0);
/** @param {number[]} values */
export const mean = (values) => sum(values) / values.length;
/** @param {number} value */
export const rounded = (value, digits = 6) => Number(value.toFixed(digits));
/** @param {ArrayLike<number>} row */
export const roundedRow = (row) => Array.from(row, (value) => rounded(value));
