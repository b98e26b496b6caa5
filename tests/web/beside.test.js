/** The second map: what it counts and says, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { counted, right, sentence } from "../../app/web/explore/beside.js";
import { gaps } from "../../app/web/explore/maps.js";
import { html } from "../../app/web/shared/text.js";
import { frames } from "./browser.js";

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

test("the sentence says what changes from the left map to the right", () => {
  const said = `${sentence({ all: 4000, corrected: 823, broken: 86, wrong: 310 })}`;
  assert.match(said, /<b>1,219<\/b> of 4,000 predictions change.*823 corrected.*86 broken.*310 still wrong/s);
  assert.match(`${sentence({ all: 0, corrected: 0, broken: 0, wrong: 0 })}`, /There are no test pairs here/);
});

test("a map names both gaps, and an accuracy only where the head predicts", () => {
  const gapsOf = { "modality_gap/f_hat": [0.25], "domain_gap/f_hat": [0.5], "modality_gap/raw": [0.97] };
  const curves = { ...gapsOf, "accuracy/unseen": [0.589] };
  const shown = frames({ curves, orders: [0.5], head: { learned_order: 0.5 } });
  const words = (parts) => `${html`${parts}`}`;
  assert.match(words(gaps(shown, "f_hat", 0)), /modality gap <b>0.25.*domain gap <b>0.50/);
  assert.match(
    words(right(shown, "f_hat", 0)),
    /58\.9.*Measured with the loaded head.*, trained on A and tested on the same pairs\.<\/p>$/,
  );
  assert.equal(words(right(shown, "raw", 0)), "");
});
