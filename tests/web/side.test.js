/** One side of Compare: which head's frames it shows, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";

globalThis.OffscreenCanvas ??= class {
  getContext() {
    return {};
  }
};
const { Side, SIDES } = await import("../../app/web/compare/side.js");
const { state } = await import("../../app/web/shared/store.js");

/** A side without a map; its parts are the properties that `load` sets. */
function side() {
  const parts = { ".side-wait": { hidden: true, textContent: "", classList: { toggle() {} } }, ".order": {} };
  return Object.assign(Object.create(Side.prototype), {
    keys: SIDES[1],
    box: { querySelector: (name) => parts[name] },
    parts,
  });
}

test("the late failure of one head does not mark the head chosen since as failed", async () => {
  const own = { pairs: 2 };
  const one = side();
  let fail;
  globalThis.fetch = () => new Promise((_, reject) => (fail = () => reject(new TypeError("lost"))));
  state.head = "slow";
  const late = one.load(own, () => {});
  state.head = "";
  await one.load(own, () => {});
  fail();
  await late;
  assert.equal(one.failed, false);
  assert.equal(one.frames, own);
  assert.equal(one.parts[".side-wait"].hidden, true);
});

test("no figure of one head stands under the name of another while that one is computed", () => {
  const one = side();
  one.frames = { meta: { curves: { "accuracy/unseen": [0.5] } }, stop: () => 0 };
  one.loaded = "";
  state.head = "other";
  assert.ok(Number.isNaN(one.value({ name: "accuracy" })));
  state.head = "";
});
