/** The loaded set: what is requested for it. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { theSet } from "../../app/web/shared/theset.js";

globalThis.document.dispatchEvent ??= () => true;

/** A frames file of one pair, without maps. */
function file() {
  const names = ["domain", "label", "prediction", "confidence"];
  const arrays = Object.fromEntries(names.map((name, offset) => [name, { dtype: "u8", shape: [1], offset }]));
  const meta = { orders: [0], pairs: 1, domains: ["A"], classes: ["wood"], arrays, embeddings: {} };
  const json = new TextEncoder().encode(JSON.stringify(meta));
  const bytes = new Uint8Array(12 + json.length + names.length);
  bytes.set(new TextEncoder().encode("OVFRAMES"));
  new DataView(bytes.buffer).setUint32(8, json.length, true);
  bytes.set(json, 12);
  return bytes.buffer;
}

test("no thumbnails are requested for a set that has none", async () => {
  const asked = [];
  globalThis.fetch = async (url) => {
    asked.push(new URL(url).pathname);
    return new Response(file(), { headers: { "X-Thumbnails": "none" } });
  };
  const { frames, sprite } = await theSet();
  assert.equal(frames.pairs, 1);
  assert.equal(sprite, null);
  assert.deepEqual(asked, ["/omnivat/frames"]);
});
