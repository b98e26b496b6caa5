import assert from "node:assert/strict";
import test from "node:test";
import { frames } from "./browser.js";

const { levels, stairs } = await import("../../app/web/explore/staircase.js");
const { histogram, shifted } = await import("../../app/web/explore/finder.js");
const { addressOf } = await import("../../app/web/explore/sets.js");
const { inView } = await import("../../app/web/explore/pictures.js");
const { Scene } = await import("../../app/web/explore/scene.js");
const { home } = await import("../../app/web/explore/curves.js");
const { score, story } = await import("../../app/web/explore/strangers.js");
const { modeWords } = await import("../../app/web/explore/modes.js");
const { change } = await import("../../app/web/shared/store.js");
globalThis.history = { state: null, replaceState: () => {} };

test("a larger value is a higher tread; a missing one keeps the height of the one before", () => {
  const heights = levels([0.1, 0.9, Number.NaN, 0], [0, 1]);
  assert.ok(heights[1] < heights[0]);
  assert.equal(heights[2], heights[1]);
  assert.ok(heights[3] > heights[0]);
  assert.match(stairs(heights), /^M0 [\d.]+H1V[\d.]+H2V[\d.]+H3V[\d.]+H4$/);
});

test("a histogram counts every value once, those at the ends too", () => {
  const counts = histogram([0, 0.5, 1, 2, -1], [0, 1]);
  assert.equal(
    counts.reduce((a, b) => a + b),
    5,
  );
  assert.equal(counts.at(-1), 2);
  assert.equal(histogram([0, 1], [0, 1], (i) => i === 1)[0], 0);
});

test("another set is opened without pins, filters and pairs of the present one", () => {
  const address = new URL(addressOf("chirps", "http://x/?set=sensors&pin=3&domain=a&p=0.5&stage=relu"));
  assert.deepEqual(Object.fromEntries(address.searchParams), { set: "chirps", stage: "relu" });
});

test("pictures are drawn only where few points are in view", () => {
  const cloud = { count: 4, x: [1, 2, 3, -5], y: [1, 1, 1, 1], width: 10, height: 10 };
  assert.deepEqual(
    inView(cloud, () => true, 3),
    [0, 1, 2],
  );
  assert.equal(
    inView(cloud, () => true, 2),
    null,
  );
  assert.deepEqual(
    inView(cloud, (point) => point === 1, 2),
    [1],
  );
});

test("a filter takes hidden points out of the selection and is named in the title", () => {
  const scene = new Scene(frames(), null);
  scene.selected = new Set([0, 1, 2, 3]);
  change({ domain: "A" });
  assert.equal(scene.refilter(), true);
  assert.deepEqual([...scene.selected], [1, 3]);
  assert.equal(scene.loneDomain(), "B");
  assert.deepEqual(scene.filtering(), ["B"]);
  change({ domain: "" });
  scene.refilter();
  assert.deepEqual(scene.filtering(), []);
});

test("pairs are found by name, class and domain, and look-alikes by what they imitate", () => {
  const scene = new Scene(frames(), null);
  scene.facts.pairs = { name: ["bowl-1", "bowl-2"], looks_like: ["", "wood"], feels_like: ["", ""] };
  const kept = () => [0, 1].filter((pair) => scene.wantedPairs()(pair));
  change({ find: "BOWL steel" });
  assert.deepEqual(kept(), [1]);
  change({ find: "", alike: "1" });
  assert.deepEqual(kept(), [1]);
  change({ alike: "" });
  scene.facts.unseen = { pairs: { confidence: [0.2, 0.9], cosine: [0, 0] } };
  change({ range: "confidence:0:0.5" });
  assert.deepEqual(kept(), [0]);
  change({ range: "" });
});

test("only a head whose p was learned has orders that it is at home with", () => {
  assert.deepEqual(home(frames({ head: { learned_order: 0.5 } })), [0.47, 0.53]);
  assert.equal(home(frames({ head: { kind: "every", learned_order: 0.5 } })), null);
  assert.equal(home(frames({ head: { kind: "retrained", learned_order: null } })), null);
});

test("the story names the source, counts the strangers, and scores them at the learned p", () => {
  assert.match(
    story({ source: "A", domains: ["A", "B", "C"] }),
    /Learned from <b class="source">A<\/b>; meets <b>two strangers/,
  );
  assert.match(story({ source: "Z", domains: ["A"] }), /not in this set.*one stranger</);
  const own = { share: 0.6, low: 0.5, high: 0.7 };
  assert.match(
    score({ unseen: { "answers/fused": own }, chance: 0.2 }, "0.509"),
    /60\u00a0%.*learned p = 0\.509.*50–70\u00a0%.*guessing: 20\u00a0%/,
  );
  assert.equal(score({ unseen: { "answers/fused": null } }, "0.5"), "");
});

test("each mode of p says what a stop is", () => {
  assert.match(
    modeWords(frames({ head: { kind: "retrained", seeds: [0, 1], width: 64 } })),
    /A head for each stop.*2 trainings for each stop, width 64/,
  );
  assert.match(
    modeWords(frames({ head: { learned_order: 0.5014 }, curves: { "accuracy/unseen": [0.3, 0.9, 0.4] } })),
    /What if only p moved\?.*p = 0\.501.*Elsewhere its mean accuracy in unseen domains is 35\u00a0% \(guessing: 50/,
  );
  assert.match(modeWords(frames({ head: { kind: "every" } })), /One head for every p/);
});

test("a range of a histogram is named with its ends, so that titles and captions tell what is hidden", () => {
  const scene = new Scene(frames(), null);
  change({ range: "cosine:0.2:0.4~junk:1:2~confidence:x:1~confidence:0.5" });
  assert.deepEqual(scene.filtering(), ["photo–touch cosine 0.20 to 0.40"]);
  assert.deepEqual(scene.ranges, { cosine: [0.2, 0.4] });
  change({ range: "" });
});

test("both ends of a range move by keys, and neither passes the other or leaves the histogram", () => {
  assert.deepEqual(shifted(undefined, [0, 1], 1, false), [0.05, 1]);
  assert.deepEqual(shifted([0.05, 1], [0, 1], -2, true), [0.05, 0.9]);
  assert.deepEqual(shifted([0.5, 0.52], [0, 1], 3, false), [0.52, 0.52]);
  assert.deepEqual(shifted([0.5, 0.52], [0, 1], -9, true), [0.5, 0.5]);
  assert.deepEqual(shifted([0.5, 1], [0, 1], 1, true), [0.5, 1]);
});
