import assert from "node:assert/strict";
import test from "node:test";
import "./browser.js";

globalThis.location = {
  search: "?chapter=where&p=0.5014&p2=x&view=elsewhere&stage=relu&colour=constructor&pin=-3&class=a%2520b&nonsense=1",
  href: "http://x/",
};
globalThis.history = { state: null, replaceState: () => {} };
const store = await import("../../app/web/shared/store.js");
const { after, change, hidden, toggle, watch } = store;

test("an address gives what is known and leaves the rest out", () => {
  assert.equal(store.state.p, 0.5014);
  assert.equal(store.state.view, "explore");
  assert.equal(store.state.stage, "relu");
  assert.equal(store.state.colour, "domain");
  assert.equal(store.state.p2, null);
  assert.equal(store.state.pin, null);
  assert.equal(store.state.chapter, "where");
  assert.ok(!("nonsense" in store.state));
});

test("a name with a tilde or a percent sign can be hidden and shown again", () => {
  change({ domain: "" });
  for (const name of ["lab~A", "100 % wool", "%7E", "plain"]) toggle("domain", name);
  assert.deepEqual([...hidden("domain")], ["lab~A", "100 % wool", "%7E", "plain"]);
  toggle("domain", "lab~A");
  assert.deepEqual([...hidden("domain")], ["100 % wool", "%7E", "plain"]);
});

test("a value changes by one way alone, which everyone who watches it hears", () => {
  const before = store.state;
  assert.throws(() => {
    store.state.p = 0.25;
  }, TypeError);
  const heard = [];
  const stop = watch(["p"], () => heard.push(store.state.p));
  change({ p: 0.25 });
  change({ p: 0.25 });
  stop();
  change({ p: 0.5 });
  assert.deepEqual([heard, before.p], [[0.25], 0.5014]);
});

test("p crosses no tab from the chapter of the order alone, and nothing else is touched", () => {
  const explore = { chapter: "order", view: "explore", p: 0.8, otherP: 0.3, pin: 1 };
  const pair = after(explore, { view: "pair" });
  assert.deepEqual(pair, { ...explore, view: "pair", p: 0.3, otherP: 0.8 });
  assert.deepEqual(after(pair, { view: "train" }), { ...pair, view: "train" });
  assert.deepEqual(after(pair, { view: "explore" }), explore);
  const other = { ...explore, chapter: "analyse" };
  assert.deepEqual(after(other, { view: "pair" }), { ...other, view: "pair" });
});

test("Back to an address that was left before p was known keeps p in its chapter, and forgets it in another", () => {
  let back;
  globalThis.addEventListener = (_, action) => (back = action);
  store.followHistory(() => {});
  change({ p: 0.5 });
  location.search = "?chapter=where";
  back();
  assert.equal(store.state.p, 0.5);
  location.search = "?chapter=touch";
  back();
  assert.equal(store.state.p, null);
});
