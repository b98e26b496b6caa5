/** The loaded set: what is requested for it, and in which order its maps come. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { fetchFrames } from "../../app/web/shared/frames.js";
import { theSet } from "../../app/web/shared/theset.js";

globalThis.document.dispatchEvent ??= () => true;

const u8 = (shape) => ({ dtype: "u8", shape, offset: 0 });
const BOUNDS = [
  [0, 0],
  [1, 1],
];
/** The head part of frames of one pair at three stops, with one map. */
const head = () => ({
  orders: [0, 0.5, 1],
  pairs: 1,
  domains: ["A"],
  classes: ["wood"],
  arrays: {
    ...{ domain: u8([1]), label: u8([1]), prediction: u8([3, 1]), confidence: u8([3, 1]) },
    map: { dtype: "u16", shape: [3, 2, 2], offset: 0 },
    "map:b": { dtype: "u16", shape: [3, 2, 2], offset: 0 },
  },
  maps: { "umap/f_hat": { array: "map:b", orders: [0, 1, 2], bounds: BOUNDS, max_error: 0.25 } },
  curves: {},
  embeddings: {},
  inline: { domain: "AA==", label: "AA==" },
  extents: { "map:b": [] },
  tag: "t1",
});

test("no thumbnails are requested for a set that has none, and no map before it is shown", async () => {
  const requested = [];
  globalThis.fetch = async (url) => {
    requested.push(new URL(url).pathname + new URL(url).search);
    const isHead = requested.length === 1;
    return new Response(isHead ? JSON.stringify(head()) : new Uint8Array(3), { headers: { "X-Thumbnails": "none" } });
  };
  const { frames, sprite } = await theSet();
  assert.equal(frames.pairs, 1);
  assert.equal(frames.error, 0.5);
  assert.equal(sprite, null);
  assert.deepEqual(requested, ["/omnivat/frames?part=head", "/omnivat/frames?part=prediction&from=0&of=t1"]);
});

test("the shown stop of a map comes first and is drawn before the others, again if the line is lost", async () => {
  let source;
  const requested = [];
  globalThis.fetch = async (url) => {
    const { part, from } = Object.fromEntries(new URL(url).searchParams);
    if (part === "head") return new Response(JSON.stringify(head()));
    requested.push([part, Number(from)]);
    return new Response(
      part === "map:b" ? new ReadableStream({ start: (control) => (source = control) }) : new Uint8Array(3),
    );
  };
  const { frames } = await fetchFrames(() => {});
  let arrivals = 0;
  frames.arrivals.add(() => (arrivals += 1));
  assert.equal(frames.positions("umap", "f_hat", 2), null);
  assert.equal(frames.positions("umap", "f_hat", 2), null);
  const settled = () => new Promise((done) => setTimeout(done, 5));
  const stop = (v) => new Uint8Array(new Uint16Array([v, v, v, v]).buffer);
  await settled();
  source.enqueue(stop(7).subarray(0, 3));
  await settled();
  assert.equal(frames.positions("umap", "f_hat", 2), null);
  source.error(new TypeError("the connection was lost"));
  await settled();
  source.enqueue(stop(7).subarray(0, 3));
  source.enqueue(new Uint8Array([...stop(7).subarray(3), ...stop(5)]));
  await settled();
  assert.deepEqual(
    [frames.positions("umap", "f_hat", 2).points[0], frames.positions("umap", "f_hat", 0).drawn],
    [7, 1],
  );
  source.enqueue(stop(3));
  source.close();
  await settled();
  assert.equal(frames.positions("umap", "f_hat", 0).points[0], 3);
  assert.deepEqual(requested, [
    ["prediction", 0],
    ["map:b", 2],
    ["map:b", 2],
    ["confidence", 0],
  ]);
  assert.ok(arrivals > 2 && frames.confidence.length === 3);
  assert.equal(frames.only([0, 2]).confidence.length, 2);
});
