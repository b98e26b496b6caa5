import assert from "node:assert/strict";
import test from "node:test";
import "./browser.js";

globalThis.location = {
  search: "?chapter=where&p=0.5014&view=elsewhere&stage=relu&pin=-3&class=a%2520b&nonsense=1",
  href: "http://x/",
};
globalThis.history = { state: null, replaceState: () => {} };
const { change, hidden, state, toggle } = await import("../../app/web/shared/store.js");

test("an address gives what is known and leaves the rest out", () => {
  assert.equal(state.p, 0.5014);
  assert.equal(state.view, "explore");
  assert.equal(state.stage, "relu");
  assert.equal(state.pin, null);
  assert.equal(state.chapter, "where");
  assert.ok(!("nonsense" in state));
});

test("a name with a tilde or a percent sign can be hidden and shown again", () => {
  change({ domain: "" });
  for (const name of ["lab~A", "100 % wool", "%7E", "plain"]) toggle("domain", name);
  assert.deepEqual([...hidden("domain")], ["lab~A", "100 % wool", "%7E", "plain"]);
  toggle("domain", "lab~A");
  assert.deepEqual([...hidden("domain")], ["100 % wool", "%7E", "plain"]);
});
