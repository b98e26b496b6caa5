/** Compare: what it counts and says, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { counted, difference, sentence } from "../../app/web/compare/changes.js";
import { dots } from "../../app/web/compare/matrix.js";

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
  assert.deepEqual(counted([0, 1], of(LEFT), of(RIGHT), of(TRUTH)), { all: 2, corrected: 1, broken: 0, wrong: 0 });
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
  assert.match(sentence(["a", "b"], { all: 0, corrected: 0, broken: 0, wrong: 0 }), /There are no test pairs here/);
});

test("names of heads cannot become markup", () => {
  assert.ok(!sentence(["<b>", "x"], { all: 1, corrected: 0, broken: 0, wrong: 0 }).includes("<b> "));
});

test("a difference has its sign, and none where there is no figure", () => {
  assert.equal(difference(0.5, 0.75), "−0.250");
  assert.equal(difference(NaN, 0.75), "");
  assert.equal(difference(0.556, 0.503, true), "+5.3 points"); // shares are written in percent
});

test("methods are dots with intervals, the best first, and no order is claimed where they overlap", () => {
  const ranking = [
    {
      label: "<b>",
      scores: [
        [0.5, 0.45, 0.55],
        [0.4, 0.3, 0.5],
      ],
    },
    {
      label: "mean",
      scores: [
        [0.52, 0.46, 0.57],
        [0.2, 0.1, 0.3],
      ],
    },
  ];
  const html = dots(ranking, 0);
  assert.ok(html.indexOf("mean") < html.indexOf("&lt;b&gt;"));
  assert.match(html, /52\.0 <small>46–57/);
  assert.match(html, /no order is certain/);
  assert.ok(dots(ranking, 1).indexOf("mean") > dots(ranking, 1).indexOf("&lt;b&gt;"));
  assert.equal(dots(ranking.slice(1), 0), "");
});
