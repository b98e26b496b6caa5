/** Live: a stopped run and one that was started before the last reply to it came; a source opened twice at once. */

import "./browser.js";
import assert from "node:assert/strict";
import test from "node:test";

globalThis.sessionStorage ??= { getItem: () => null, setItem() {} };
globalThis.localStorage ??= globalThis.sessionStorage;
const { Feed } = await import("../../app/web/pair/feed.js");
const { live } = await import("../../app/web/pair/live.js");

const pause = () => new Promise((done) => setTimeout(done, 20));

test("a run of Live that was stopped leaves the cameras of a newer one open", async () => {
  const waiting = [];
  globalThis.fetch = () => new Promise((reply) => waiting.push(() => reply(Response.json({ ms: {}, classes: [] }))));
  const feed = {
    ...{ modality: "tac", on: false, menus: { device: { value: "file" } }, canvas: { width: 8, height: 8 } },
    draw: () => null,
    blob: async () => new Blob(["x"]),
    open: async () => (feed.on = true),
    close: () => (feed.on = false),
  };
  const tab = { on: true, taught: false, pairs: [], head: "" };
  const desk = { feeds: [feed], tab, send() {}, box: { querySelector: () => ({ value: "", scrollIntoView() {} }) } };
  const [first, second] = [new AbortController(), new AbortController()];
  const stopped = live(desk, {}, first.signal);
  await pause();
  assert.ok(feed.on && waiting.length);
  tab.on = false;
  first.abort();
  assert.ok(!feed.on);
  tab.on = true;
  const newer = live(desk, {}, second.signal);
  await pause();
  for (const reply of waiting.splice(0)) reply();
  await stopped;
  assert.ok(feed.on);
  tab.on = false;
  second.abort();
  for (const reply of waiting.splice(0)) reply();
  await pause();
  for (const reply of waiting.splice(0)) reply();
  await newer;
  assert.ok(!feed.on);
});

test("of a camera that is opened twice at once one stream stays on, and none after a close", async () => {
  const waiting = [];
  globalThis.MediaStream = class {
    track = { on: true, stop: () => (this.track.on = false) };
    getTracks = () => [this.track];
    getVideoTracks = this.getTracks;
  };
  const mediaDevices = { getUserMedia: () => new Promise((reply) => waiting.push(reply)) };
  Object.defineProperty(globalThis, "navigator", { value: { mediaDevices } });
  document.createElement = () => ({ play: async () => {}, load() {}, removeAttribute() {} });
  const part = (what) => ({ className: what.slice(1), value: "camera" });
  const feed = new Feed({ dataset: { modality: "tac" }, querySelector: part }, () => {});
  const opened = [feed.open(), feed.open()];
  const streams = waiting.splice(0).map((reply) => {
    const stream = new MediaStream();
    reply(stream);
    return stream;
  });
  await Promise.all(opened);
  assert.deepEqual([streams.map(({ track }) => track.on), feed.video.srcObject], [[false, true], streams[1]]);
  opened.push(feed.open());
  feed.close();
  const late = new MediaStream();
  waiting[0](late);
  await Promise.all(opened);
  assert.ok(!late.track.on && !feed.video.srcObject);
});
