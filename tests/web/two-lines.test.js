/** The prediction of a pair is shown before the rest of its reply, where the rest is slow. */

import "./browser.js";
import assert from "node:assert/strict";
import test from "node:test";

globalThis.sessionStorage ??= { getItem: () => null, setItem() {} };
globalThis.localStorage ??= globalThis.sessionStorage;
const { WORK } = await import("../../app/web/pair/work.js");

const REST = { familiar: { images: {} }, journey: { maps: {} } };
const encoded = (/** @type {string} */ text) => new TextEncoder().encode(text);
const pause = (/** @type {number} */ ms) => new Promise((done) => setTimeout(done, ms));

/** The events of a pair's prediction whose second line follows after a pause. */
async function events(/** @type {number} */ ms, control = new AbortController()) {
  globalThis.fetch = async () =>
    new Response(
      new ReadableStream({
        async start(body) {
          const whole = encoded(`${JSON.stringify({ linear: false, classes: ["é"] })}\n`);
          body.enqueue(whole.slice(0, 30)); // it comes in parts, one of which ends inside a letter
          body.enqueue(whole.slice(30));
          await pause(ms);
          body.enqueue(encoded(JSON.stringify(REST)));
          body.close();
        },
      }),
    );
  const sent = [];
  const send = (name, detail) => name === "predicted" && sent.push(detail);
  const tab = { vis: "row:1", tac: null, heads: [], taught: false, pairs: [] };
  await WORK.predict({ tab, send, map: null }, {}, control.signal);
  return sent;
}

test("a prediction waits a moment for the rest, so that nothing flickers", async () => {
  const [all, ...more] = await events(0);
  assert.deepEqual(more, []);
  assert.deepEqual([all.answer.classes, all.familiar, all.journey], [["é"], REST.familiar, REST.journey]);
});

test("on a busy server the prediction is shown first, and the rest when it is there", async () => {
  const [first, all, ...more] = await events(400);
  assert.deepEqual([first.answer.classes, first.familiar, more], [["é"], undefined, []]);
  assert.deepEqual([all.answer.classes, all.familiar], [["é"], REST.familiar]);
});

test("of a pair that was left, nothing is shown afterwards", async () => {
  const control = new AbortController();
  const left = events(400, control);
  await pause(50);
  control.abort();
  const shown = await left;
  assert.equal(shown.filter(({ familiar }) => !familiar).length, 0);
});
