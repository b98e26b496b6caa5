/** What a page without a server reads, and where it cannot run. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { whole } from "../../app/web/site/decode.js";
import { onLinear } from "../../app/web/site/journey.js";
import { inTurn, runtime } from "../../app/web/site/runtime.js";
import { nearest, stacked, tensors } from "../../app/web/site/tensors.js";

globalThis.self ??= /** @type {any} */ ({});
const nothing = () => Promise.resolve(new ArrayBuffer(0));

test("a browser without WebAssembly, or without SIMD, gets a sentence", async () => {
  const { WebAssembly: own } = globalThis;
  for (const kind of [undefined, { validate: () => false }]) {
    globalThis.WebAssembly = /** @type {any} */ (kind);
    await assert.rejects(runtime("http://x/", nothing), /has no WebAssembly with SIMD/);
  }
  globalThis.WebAssembly = own;
  await assert.rejects(runtime("file:///nowhere/", nothing), /did not arrive/); // this one has SIMD
});

test("the runtime does one thing at a time, in their order, and a failure stops nothing", async () => {
  const seen = [];
  const work = (name, fails) => async () => {
    seen.push(name);
    await new Promise((resolve) => setTimeout(resolve, 5));
    seen.push(`${name} done`);
    if (fails) throw new Error(name);
    return name;
  };
  const all = [inTurn(work("a")), inTurn(work("b", true)), inTurn(work("c"))];
  const [first, second, third] = await Promise.allSettled(all);
  assert.deepEqual(seen, ["a", "a done", "b", "b done", "c", "c done"]);
  assert.deepEqual([first.value, second.reason.message, third.value], ["a", "b", "c"]);
});

test("a file of numbers is read, and a damaged one is refused", () => {
  const head = JSON.stringify({ a: { dtype: "F32", shape: [3], data_offsets: [0, 12] } });
  const bytes = new Uint8Array(8 + head.length + 12);
  new DataView(bytes.buffer).setBigUint64(0, BigInt(head.length), true);
  bytes.set(new TextEncoder().encode(head), 8);
  bytes.set(new Uint8Array(Float32Array.of(1, 2.5, -3).buffer), 8 + head.length);
  assert.deepEqual([...tensors(bytes.buffer).a.values], [1, 2.5, -3]);
  assert.throws(() => tensors(bytes.slice(0, -2).buffer), /cannot be read as a file of numbers/);
});

test("the nearest rows are those of the largest cosines, without a row that is left out", () => {
  const rows = [
    [1, 0],
    [0, 1],
    [0.6, 0.8],
  ];
  const found = (except) => nearest(rows, [0, 1], 2, except).map(({ point, cosine }) => [point, cosine]);
  assert.deepEqual(found(-1), [
    [1, 1],
    [2, 0.8],
  ]);
  assert.deepEqual(found(1), [
    [2, 0.8],
    [0, 0],
  ]);
});

test("a linear map places any row", () => {
  assert.deepEqual(
    onLinear(
      [2, 3],
      stacked([
        [1, 0, 5],
        [0, 1, -1],
      ]),
    ),
    [7, 2],
  );
});

test("a picture is whole with anything behind it, and not with only its preview's end", () => {
  const start = [0xff, 0xd8, 0xff, 0xe1, 0, 8, 0xff, 0xd8, 1, 1, 0xff, 0xd9]; // a preview in its notes
  const scan = [0xff, 0xda, 0, 2, 7, 0xff, 0, 9];
  assert.ok(whole(Uint8Array.of(...start, ...scan, 0xff, 0xd9, ...new Array(9000).fill(5))));
  assert.ok(!whole(Uint8Array.of(...start, ...scan)));
  const piece = (name, size) => [
    0,
    0,
    0,
    size,
    ...[...name].map((c) => c.charCodeAt(0)),
    ...new Array(size + 4).fill(1),
  ];
  const png = [0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10, ...piece("IDAT", 9), ...piece("IEND", 0)];
  assert.ok(whole(Uint8Array.of(...png, ...new Array(9000).fill(5))));
  assert.ok(!whole(Uint8Array.of(...png.slice(0, -13))));
});
