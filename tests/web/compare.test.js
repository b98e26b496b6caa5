/** Compare: what it counts and says, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { counted, difference, sentence } from "../../app/web/compare/changes.js";

const TRUTH = ["wood", "wood", "steel", "steel", "glass"];
const LEFT = ["wood", "steel", "steel", "wood", "wood"];
const RIGHT = ["wood", "wood", "wood", "glass", "wood"];

test("only pairs that count are counted, and changes are corrected, broken or still wrong", () => {
  const of = (names) => (pair) => names[pair];
  assert.deepEqual(counted([0, 1, 2, 3, 4], of(LEFT), of(RIGHT), of(TRUTH)), {
    all: 5,
    corrected: 1,
    broken: 1,
    wrong: 1,
  });
  assert.deepEqual(counted([0, 1], of(LEFT), of(RIGHT), of(TRUTH)), {
    all: 2,
    corrected: 1,
    broken: 0,
    wrong: 0,
  });
});

test("the sentence says what changes, and between whom", () => {
  const said = sentence(["nearest class mean", "the head at p = 0.51"], {
    all: 4000,
    corrected: 823,
    broken: 86,
    wrong: 310,
  });
  assert.match(said, /<b>1,219<\/b> of 4,000 predictions change/);
  assert.match(said, /823 corrected.*86 broken.*310 still wrong/);
});

test("two equal sides are told to differ", () => {
  assert.match(sentence(["a", "a"], { all: 1, corrected: 0, broken: 0, wrong: 0 }), /same predictions/);
  assert.match(
    sentence(["a", "b"], { all: 0, corrected: 0, broken: 0, wrong: 0 }),
    /There are no test pairs here/,
  );
});

test("names of heads cannot become markup", () => {
  assert.ok(!sentence(["<b>", "x"], { all: 1, corrected: 0, broken: 0, wrong: 0 }).includes("<b> "));
});

test("a difference has its sign, and none where there is no figure", () => {
  assert.equal(difference(0.5, 0.75), "−0.250");
  assert.equal(difference(NaN, 0.75), "");
  assert.equal(difference(0.556, 0.503, true), "+5.3 points"); // shares are written in percent
});
