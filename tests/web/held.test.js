import "./browser.js";
import assert from "node:assert/strict";
import test from "node:test";

const index = {
  files: {
    "sensors/frames?mode=every": "data/every.bin",
    'sensors/predictions {"method":"É"}': "data/predictions.json",
    "chirps/example/A b/c%/vis": "data/picture.webp",
  },
  refused: { "chirps/toy": "The set has no map." },
  home: "sensors",
  sets: ["sensors", "chirps"],
  alone: "This needs Python.",
  models: {},
};
globalThis.document = {
  ...globalThis.document,
  baseURI: "http://x/Kurs%20%C3%A9/index.html?view=pair",
  querySelector: () => ({ textContent: JSON.stringify(index) }),
};
const fetched = [];
globalThis.fetch = async (address) => {
  fetched.push(address);
  return new Response("{}");
};
const { address, ask, get } = await import("../../app/web/shared/api.js");

test("a request about a set is a file, whatever the folder is called", async () => {
  assert.equal(address("frames?set=sensors&mode=every"), "data/every.bin");
  assert.equal(address("frames?mode=every"), "data/every.bin");
  assert.equal(address("example/A%20b/c%25/vis?set=chirps"), "data/picture.webp");
  await ask("predictions", { method: "É" });
  assert.deepEqual(fetched, ["data/predictions.json"]);
});

test("what needs a server, and what the server would refuse, is a sentence", async () => {
  await assert.rejects(() => ask("trainings", {}), /This needs Python/);
  await assert.rejects(() => get("toy?set=chirps"), /The set has no map/);
  await assert.rejects(() => get("toy?set=f00"), /do not hold the set/);
});

test("a request with a picture goes to the worker, with its set and its parameters apart", async () => {
  const { held } = await import("../../app/web/shared/held.js");
  held.local = `data:text/javascript,${encodeURIComponent(
    'export const ROUTES = new Set(["live"]);' +
      'export const respond = async (asked) => { globalThis.asked = asked; return new Response("{}"); };',
  )}`;
  const body = new Blob(["x"]);
  await get("live?modality=vis&set=chirps", { method: "POST", body });
  const { path, set, query, body: sent } = globalThis.asked;
  assert.deepEqual([path, set, String(query), sent], ["live", "chirps", "modality=vis", body]);
  await assert.rejects(() => get("save/figure", { method: "POST", body: "{}" }), /This needs Python/);
});
