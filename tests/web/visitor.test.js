/** Train here: what a browser keeps of a visitor. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { keep, kept, visitor } from "../../app/web/train/plan.js";

/** A storage like a browser's; `refuses` as in a frame of another site. */
function storage(refuses) {
  const all = new Map();
  const guarded = (action) => (key, text) => {
    if (refuses) throw new DOMException("denied", "SecurityError");
    return action(key, text);
  };
  Object.defineProperty(globalThis, "localStorage", {
    configurable: true,
    value: { getItem: guarded((key) => all.get(key) ?? null), setItem: guarded((key, text) => all.set(key, text)) },
  });
}

for (const refuses of [false, true]) {
  test(`a visitor keeps one name and one training${refuses ? " where storage is refused" : ""}`, () => {
    storage(refuses);
    assert.ok(visitor().length > 10);
    assert.equal(visitor(), visitor());
    assert.equal(kept(), null);
    keep({ started: { run: "a" }, question: {} });
    assert.equal(kept().started.run, "a");
    keep(null);
    assert.equal(kept(), null);
  });
}
