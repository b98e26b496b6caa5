/** A Parquet file of one row group, plain and uncompressed. No DOM here. */

/**
 * A column of a file: numbers, texts, lists of one text each, or pictures.
 * @typedef {{name: string, kind: "int64" | "float" | "double", values: number[]}
 *   | {name: string, kind: "text", values: string[]}
 *   | {name: string, kind: "texts", values: string[]}
 *   | {name: string, kind: "image", values: Uint8Array[]}} Column
 */
/** A value of Thrift's compact protocol, after its type: fields are by their numbers, a list's type is its items'.
 * @typedef {["i32" | "i64", number] | ["text", string] | ["list", Value[]] | ["fields", Record<number, Value>]} Value
 */
/** Values in the file: a column, or a part of one.
 * @typedef {{path: string[], type: number, parts: Uint8Array[]}} Leaf */

const CODES = { i32: 5, i64: 6, text: 8, list: 9, fields: 12 };
const [INT64, FLOAT, DOUBLE, BYTES] = [2, 4, 5, 6];
const [REQUIRED, REPEATED] = [0, 2];
const [UTF8, LIST] = [0, 3]; // what bytes and groups stand for
const [PLAIN, LEVELS] = [0, 3]; // encodings
const MARK = utf8("PAR1");

/** @param {string} text */
function utf8(text) {
  return new TextEncoder().encode(text);
}

/** @param {number} value @returns {number[]} */
const varint = (value) => (value < 128 ? [value] : [(value % 128) + 128, ...varint(Math.floor(value / 128))]);

/** Return the bytes of a value. @param {Value} value @returns {number[]} */
function encoded([type, value]) {
  if (type === "text") return [...varint(utf8(value).length), ...utf8(value)];
  if (type === "list") {
    const code = CODES[value[0][0]];
    const head = value.length < 15 ? [16 * value.length + code] : [240 + code, ...varint(value.length)];
    return [...head, ...value.flatMap(encoded)];
  }
  if (type === "fields") {
    let last = 0;
    const bytes = Object.entries(value).flatMap(([number, inner]) => {
      const step = +number - last;
      last = +number;
      return [16 * step + CODES[inner[0]], ...encoded(inner)];
    });
    return [...bytes, 0];
  }
  return varint(2 * value);
}

/** @param {number} value @returns {Value} */
const i32 = (value) => ["i32", value];
/** @param {number} value @returns {Value} */
const i64 = (value) => ["i64", value];
/** @param {string} value @returns {Value} */
const text = (value) => ["text", value];
/** @param {Value[]} value @returns {Value} */
const list = (value) => ["list", value];
/** @param {Record<number, Value>} value @returns {Value} */
const fields = (value) => ["fields", value];

/** @param {number} value */
const little = (value) => Uint8Array.from([0, 8, 16, 24], (shift) => value >>> shift);
/** @param {Uint8Array[]} values */
const sized = (values) => values.flatMap((value) => [little(value.length), value]);
/** @param {Uint8Array[]} parts */
const length = (parts) => parts.reduce((sum, part) => sum + part.length, 0);

/** Return numbers as the bytes of their kind, lowest byte first.
 * @param {number[]} values @param {"int64" | "float" | "double"} kind */
function numbers(values, kind) {
  const size = kind === "float" ? 4 : 8;
  const view = new DataView(new ArrayBuffer(size * values.length));
  for (const [i, value] of values.entries())
    if (kind === "int64") view.setBigInt64(8 * i, BigInt(value), true);
    else if (kind === "float") view.setFloat32(4 * i, value, true);
    else view.setFloat64(8 * i, value, true);
  return [new Uint8Array(view.buffer)];
}

/** Return the levels of lists of one value each: none repeats, each is there. @param {number} count */
const levels = (count) =>
  [0, 1].flatMap((level) => {
    const run = Uint8Array.from([...varint(2 * count), level]);
    return [little(run.length), run];
  });

/** Return an element of the schema. @param {string} name @param {Record<number, Value>} more */
const element = (name, more) => fields({ 3: i32(REQUIRED), 4: text(name), ...more });

/** Return the schema of a column, and where its values are.
 * @param {Column} column
 * @returns {{schema: Value[], leaves: Leaf[]}} */
function described(column) {
  const { name, values } = column;
  if (column.kind === "image") {
    const paths = column.values.map((_, i) => utf8(`${i}.jpg`));
    return {
      schema: [
        element(name, { 5: i32(2) }),
        element("bytes", { 1: i32(BYTES) }),
        element("path", { 1: i32(BYTES), 6: i32(UTF8) }),
      ],
      leaves: [
        { path: [name, "bytes"], type: BYTES, parts: sized(column.values) },
        { path: [name, "path"], type: BYTES, parts: sized(paths) },
      ],
    };
  }
  if (column.kind === "text" || column.kind === "texts") {
    const parts = sized(column.values.map(utf8));
    if (column.kind === "text")
      return {
        schema: [element(name, { 1: i32(BYTES), 6: i32(UTF8) })],
        leaves: [{ path: [name], type: BYTES, parts }],
      };
    return {
      schema: [
        element(name, { 5: i32(1), 6: i32(LIST) }),
        element("list", { 3: i32(REPEATED), 5: i32(1) }),
        element("element", { 1: i32(BYTES), 6: i32(UTF8) }),
      ],
      leaves: [{ path: [name, "list", "element"], type: BYTES, parts: [...levels(values.length), ...parts] }],
    };
  }
  const type = { int64: INT64, float: FLOAT, double: DOUBLE }[column.kind];
  const parts = numbers(column.values, column.kind);
  return { schema: [element(name, { 1: i32(type) })], leaves: [{ path: [name], type, parts }] };
}

/** Return a file of columns of one length. @param {Column[]} columns @param {Record<string, string>} [metadata] */
export function parquet(columns, metadata = {}) {
  const count = columns[0].values.length;
  const all = columns.map(described);
  /** @type {Uint8Array[]} */
  const body = [MARK];
  const chunks = all.flatMap(({ leaves }) =>
    leaves.map(({ path, type, parts }) => {
      const size = i32(length(parts));
      const page = fields({ 1: i32(count), 2: i32(PLAIN), 3: i32(LEVELS), 4: i32(LEVELS) });
      const header = Uint8Array.from(encoded(fields({ 1: i32(0), 2: size, 3: size, 5: page })));
      const offset = length(body);
      body.push(header, ...parts);
      const bytes = i64(length(body) - offset);
      const about = { 1: i32(type), 2: list([i32(PLAIN), i32(LEVELS)]), 3: list(path.map(text)), 4: i32(0) };
      const sizes = { 5: i64(count), 6: bytes, 7: bytes, 9: i64(offset) };
      return fields({ 2: i64(offset), 3: fields({ ...about, ...sizes }) });
    }),
  );
  const root = fields({ 4: text("schema"), 5: i32(columns.length) });
  const groups = [fields({ 1: list(chunks), 2: i64(length(body)), 3: i64(count) })];
  const notes = Object.entries(metadata).map(([key, value]) => fields({ 1: text(key), 2: text(value) }));
  /** @type {Record<number, Value>} */
  const about = { 1: i32(1), 2: list([root, ...all.flatMap(({ schema }) => schema)]), 3: i64(count), 4: list(groups) };
  if (notes.length) about[5] = list(notes);
  const footer = Uint8Array.from(encoded(fields({ ...about, 6: text("omnivat") })));
  const file = new Uint8Array(length(body) + footer.length + 8);
  let at = 0;
  for (const part of [...body, footer, little(footer.length), MARK]) {
    file.set(part, at);
    at += part.length;
  }
  return file;
}
