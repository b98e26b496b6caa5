import assert from "node:assert/strict";
import test from "node:test";
import "./browser.js";

let written = "";
globalThis.location = {
  search: "?view=pair&vis=pairs/a.png&tac=https://else.where/b.png",
  href: "http://x/?view=pair&vis=pairs/a.png",
  origin: "http://x",
};
globalThis.history = { state: null, replaceState: (_, __, address) => (written = String(address)) };
const { querySelector } = globalThis.document;
globalThis.document.querySelector = (what) =>
  what.startsWith("meta") ? { getAttribute: () => "explore pair" } : querySelector(what);
const sent = [];
globalThis.fetch = async (address, options) => {
  sent.push([String(address), options?.method ?? "GET"]);
  return new Response("bytes");
};
const store = await import("../../app/web/shared/store.js");
const { change, links } = store;
const { takeLinked } = await import("../../app/web/pair/own-pictures.js");

test("a picture of this origin is taken, one of another host is refused with its address", async () => {
  assert.equal(store.state.view, "pair");
  const { lost, sent: taken } = await takeLinked();
  const [ref] = Object.keys(taken);
  assert.equal(taken[ref].name, "a.png");
  assert.match(lost, /touch 'https:\/\/else.where\/b.png' is not on this page's host/);
  assert.deepEqual(sent, [["http://x/pairs/a.png", "GET"]]); // the next request about it sends it
  assert.deepEqual([store.state.vis, store.state.tac], [ref, null]);
});

test("the address goes on naming the picture by its own address", async () => {
  change({ tree: "A" });
  await new Promise((resolve) => setTimeout(resolve, 200));
  const query = new URL(written).searchParams;
  assert.deepEqual([query.get("vis"), query.get("view")], ["pairs/a.png", "pair"]);
  assert.equal(links.get("pairs/a.png"), store.state.vis);
});
