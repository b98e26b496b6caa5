/** What a profile does to a row; tests/unit/data/test_profile.py has the same figures. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { loaded, moved, profileFrom, saved } from "../../app/web/site/profiles.js";

const channels = (mean, variance) => ({ mean, variance, count: 6 });
const [target, source] = [channels([2, 3], [4, 1]), channels([0, 1], [1, 4])];
const AT = { 1: [-0.169048, -3.6001], 0.75: [0.087478, -3.165925], 0: [1, -2] };

test("a head's source says how much of the step is taken", () => {
  for (const [step, wanted] of Object.entries(AT))
    moved([1, -2], target, source, Number(step)).forEach((value, i) => {
      assert.ok(Math.abs(value - wanted[i]) < 1e-5, `${step}: ${value}`);
    });
  assert.deepEqual(moved([1, -2], target, source), moved([1, -2], target, source, 1));
});

test("a profile without a step takes the whole one", () => {
  const key = { name: "e", weights_hash: "w", preprocessing: "p" };
  const parts = { mean: Float32Array.of(1, 2), variance: Float32Array.of(1, 1), count: 3 };
  const found = loaded(saved({ channels: { vis: parts } }, key), key);
  assert.equal(found.step, 1);
  assert.equal(profileFrom({ ...asFile(parts), __metadata__: { ...about, step: "0.75" } }).step, 0.75);
});

test("a damaged profile is refused in a sentence before anything computes with it", () => {
  const good = { mean: Float32Array.of(1, 2), variance: Float32Array.of(1, 1) };
  const damaged = [
    [{ ...good, mean: Float32Array.of(Number.NaN, 2) }, {}],
    [{ ...good, variance: Float32Array.of(-1, 1) }, {}],
    [{ ...good, variance: Float32Array.of(Number.POSITIVE_INFINITY, 1) }, {}],
    [{ ...good, mean: Float32Array.of(1) }, {}],
    [good, { vis_count: "0" }],
    [good, { vis_count: "many" }],
  ];
  for (const [parts, more] of damaged)
    assert.throws(() => profileFrom({ ...asFile(parts), __metadata__: { ...about, ...more } }), /is damaged/);
  assert.throws(() => profileFrom({ __metadata__: about }), /is damaged/);
});

const about = { format: "omnivat-profile-1", vis_count: "3" };
const asFile = ({ mean, variance }) => ({ vis_mean: { values: mean }, vis_variance: { values: variance } });
