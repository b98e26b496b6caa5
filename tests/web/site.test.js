/** What a page without a server reads, and where it cannot run. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { factors, headerOf, rotation, whole } from "../../app/web/site/decode.js";
import { inTurn, runtime } from "../../app/web/site/runtime.js";
import { lessonsIn, ridge, shareOf, sharpness } from "../../app/web/site/teaching.js";
import { tensors, written } from "../../app/web/site/tensors.js";

globalThis.self ??= /** @type {any} */ ({});
const nothing = () => Promise.resolve(new ArrayBuffer(0));

test("a browser without WebAssembly, or without SIMD, gets a sentence", async () => {
  const { WebAssembly: own } = globalThis;
  for (const [kind, sentence] of [
    [undefined, /has no WebAssembly/],
    [{ validate: () => false }, /has no SIMD/],
  ]) {
    globalThis.WebAssembly = /** @type {any} */ (kind);
    await assert.rejects(runtime("http://x/", nothing), sentence);
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

test("a file of numbers is read as it was written, and a damaged one is refused", () => {
  const bytes = written({ a: [1, 2.5, -3], b: [0.25] }, { format: "x" });
  const found = tensors(bytes.buffer);
  assert.deepEqual([...found.a.values, ...found.b.values], [1, 2.5, -3, 0.25]);
  assert.equal(found.__metadata__.format, "x");
  assert.throws(() => tensors(bytes.slice(0, -2).buffer), /cannot be read as a file of numbers/);
});

test("sizes and kinds are read from the first bytes", () => {
  const bytes = (...parts) =>
    Uint8Array.from(parts.flatMap((one) => (typeof one === "string" ? [...one].map((c) => c.charCodeAt(0)) : one)));
  const png = bytes("\x89PNG\r\n\x1a\n", [0, 0, 0, 13], "IHDR", [0, 0, 1, 2], [0, 0, 0, 9]);
  assert.deepEqual(headerOf(png), { kind: "PNG", width: 258, height: 9 });
  const jpeg = bytes("\xff\xd8", [0xff, 0xe0, 0, 4, 1, 1], [0xff, 0xc2, 0, 11, 8, 0, 20, 1, 0, 1], [0, 0, 0, 0, 0, 0]);
  assert.deepEqual(headerOf(jpeg), { kind: "JPEG", width: 256, height: 20 });
  assert.equal(headerOf(bytes("II*\0", [0, 0, 0, 0, 0, 0, 0, 0])).kind, "TIFF");
  assert.equal(headerOf(bytes("this is no picture")), null);
  const exif = bytes("MM\0*", [0, 0, 0, 8], [0, 1], [1, 0x12, 0, 3, 0, 0, 0, 1, 0, 6, 0, 0]);
  assert.equal(rotation(exif), 6);
});

test("a picture is whole with anything behind it, and not with only its preview's end", () => {
  const start = [0xff, 0xd8, 0xff, 0xe1, 0, 8, 0xff, 0xd8, 1, 1, 0xff, 0xd9]; // a preview in its notes
  const scan = [0xff, 0xda, 0, 2, 7, 0xff, 0, 9];
  assert.ok(whole(Uint8Array.of(...start, ...scan, 0xff, 0xd9, ...new Array(9000).fill(5)), "JPEG"));
  assert.ok(!whole(Uint8Array.of(...start, ...scan), "JPEG"));
  const piece = (name, size) => [
    0,
    0,
    0,
    size,
    ...[...name].map((c) => c.charCodeAt(0)),
    ...new Array(size + 4).fill(1),
  ];
  const png = [0, 0, 0, 0, 0, 0, 0, 0, ...piece("IDAT", 9), ...piece("IEND", 0)];
  assert.ok(whole(Uint8Array.of(...png, ...new Array(9000).fill(5)), "PNG"));
  assert.ok(!whole(Uint8Array.of(...png.slice(0, -13)), "PNG"));
});

test("a large picture is made smaller in the steps of the server", () => {
  assert.deepEqual(factors("PNG", 2000, 3000), [1]);
  assert.deepEqual(factors("PNG", 3000, 4000), [2]);
  assert.deepEqual(factors("JPEG", 5472, 3648), [2, 1]);
});

test("teaching solves what the library solves: one table of cases holds both", () => {
  const table = JSON.parse(readFileSync(new URL("teaching.json", import.meta.url), "utf8"));
  const near = (found, wanted) =>
    wanted.flat().forEach((value, i) => assert.ok(Math.abs(value - found.flatMap((row) => [...row])[i]) < 1e-8));
  const rows = table.rows.map((row) => Float64Array.from(row));
  const { labels, counts, classes, lessons } = table;
  const both = ridge(rows, labels, counts, classes, lessons);
  const alone = ridge(rows.slice(0, lessons), labels.slice(0, lessons), counts.slice(0, lessons), classes, lessons);
  near(both.weights, table.weights);
  near([both.bias], [table.bias]);
  near(both.apart, table.apart);
  near(alone.apart, table.alone);
  const errors = [both, alone].map(({ apart }) =>
    apart.map((row, i) => row.map((score, k) => Number(labels[i] === k) - score)),
  );
  const share = shareOf(errors[0], errors[1]);
  const blend = both.apart.map((row, i) => row.map((score, k) => (1 - share) * score + share * alone.apart[i][k]));
  near([[share, sharpness(blend, labels.slice(0, lessons))]], [[table.share, table.sharpness]]);
});

test("lessons without a label, or of two different pairs, are refused", () => {
  assert.deepEqual(lessonsIn({}), []);
  assert.throws(() => lessonsIn({ lessons: [{ vis: "image:a", label: " " }] }), /1 to 40 letters/);
  assert.throws(() => lessonsIn({ lessons: [{ vis: "row:1", tac: "row:2", label: "a" }] }), /different pairs/);
});
