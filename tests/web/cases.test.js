/** Rules that stand in the scripts of the page without a server, too, by the table of cases that the library reads:
 * tests/app/test_cases.py. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { factors } from "../../app/web/site/decode.js";
import { onLinear } from "../../app/web/site/forest.js";
import { loaded, profileFrom, saved } from "../../app/web/site/profiles.js";
import { spectrum } from "../../app/web/site/routes.js";
import { nearest, stacked } from "../../app/web/site/tensors.js";

const CASES = JSON.parse(readFileSync(new URL("../cases.json", import.meta.url), "utf8"));
const KEY = { name: "e", weights_hash: "w", preprocessing: "p" };
const WIDTH = 2;
const close = (found, wanted) => found.forEach((value, i) => assert.ok(Math.abs(value - wanted[i]) < 1e-6, `${value}`));

/** A file of the table, as it is read. */
function read({ metadata, tensors }) {
  const vectors = Object.entries(tensors).map(([name, row]) => {
    const values = Float32Array.from(row, (one) => Number(String(one).replace("inf", "Infinity")));
    return [name, { dtype: "F32", shape: [values.length], values }];
  });
  return { __metadata__: metadata, ...Object.fromEntries(vectors) };
}

test("a sound profile is taken with its step, and comes back from a file of this page", () => {
  for (const file of CASES.profiles.good) {
    const found = profileFrom(read(file), KEY, WIDTH);
    assert.equal(found.step, Number(file.metadata.step ?? 1));
    const again = loaded(saved(found, KEY), KEY, WIDTH);
    assert.deepEqual(again.channels, found.channels);
  }
});

for (const [name, file] of Object.entries(CASES.profiles.bad))
  test(`a profile with ${name} is refused in a sentence before anything computes with it`, () => {
    assert.throws(() => profileFrom(read(file), KEY, WIDTH), /is damaged|is not a profile/);
  });

for (const [name, file] of Object.entries(CASES.profiles.other))
  test(`a profile of ${name} is refused`, () => {
    assert.throws(() => profileFrom(read(file), KEY, WIDTH), /The profile comes from/);
  });

test("a large picture is made smaller in the steps of the server", () => {
  for (const { jpeg, size, factors: wanted } of CASES.factor) assert.deepEqual(factors(jpeg, ...size), wanted);
});

test("the nearest rows are those of the largest cosines", () => {
  for (const { rows, query, count, except, found } of CASES.nearest) {
    const near = nearest(rows, query, count, except);
    assert.deepEqual(
      near.map(({ point }) => point),
      found.map(([point]) => point),
    );
    close(
      near.map(({ cosine }) => cosine),
      found.map(([, cosine]) => cosine),
    );
  }
});

test("a linear map places any row", () => {
  for (const { row, map, place } of CASES.place) close(onLinear(row, stacked(map)), place);
});

test("a spectrum is a picture of bytes", () => {
  for (const { moduli, pixels } of CASES.spectrum) {
    const bytes = Buffer.from(spectrum(stacked(moduli), moduli.length).pixels, "base64");
    assert.deepEqual([...bytes], pixels.flat());
  }
});
