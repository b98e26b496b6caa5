/** What a browser keeps of a visitor. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { keep, kept, keptJson } from "../../app/web/shared/memory.js";

/** A storage like a browser's; `refuses` as in a frame of another site. */
function storage(refuses) {
  const all = new Map();
  const guarded = (action) => (key, text) => {
    if (refuses) throw new DOMException("denied", "SecurityError");
    return action(key, text);
  };
  Object.defineProperty(globalThis, "localStorage", {
    configurable: true,
    value: {
      getItem: guarded((key) => all.get(key) ?? null),
      removeItem: guarded((key) => all.delete(key)),
      setItem: guarded((key, text) => all.set(key, text)),
    },
  });
}

for (const refuses of [false, true]) {
  test(`a text is kept until it is forgotten${refuses ? ", where storage is refused" : ""}`, () => {
    storage(refuses);
    assert.equal(kept("a"), null);
    keep("a", '{"b": 1}');
    assert.deepEqual([kept("a"), keptJson("a", 2)], ['{"b": 1}', { b: 1 }]);
    keep("a", null);
    assert.deepEqual([kept("a"), keptJson("a", 2)], [null, 2]);
  });
}
