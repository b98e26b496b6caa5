import assert from "node:assert/strict";
import test from "node:test";
import "./browser.js";
import { balance } from "../../app/web/explore/bars.js";
import { headOf, LESSONS, startOf } from "../../app/web/explore/chapters.js";
import { line } from "../../app/web/explore/curves.js";
import { histogram, ranged, shifted } from "../../app/web/explore/finder.js";
import { neighboursHtml } from "../../app/web/explore/grid.js";
import { addressOf } from "../../app/web/explore/panels.js";
import * as scenes from "../../app/web/explore/scene.js";
import { barsOf } from "../../app/web/explore/split.js";
import { levels, treads } from "../../app/web/explore/staircase.js";
import { after, START } from "../../app/web/explore/state.js";
import { lookAlikes } from "../../app/web/explore/strangers.js";
import { loadTags, tagOf, tagPairs, tagsCsv } from "../../app/web/explore/tags.js";
import { chosen, pressOf } from "../../app/web/explore/touch.js";
import { card } from "../../app/web/shared/card.js";
import { Scale } from "../../app/web/shared/chart.js";
import { Cloud } from "../../app/web/shared/cloud.js";
import { cell } from "../../app/web/shared/csv.js";
import { colouring, colouringsOf } from "../../app/web/shared/palette.js";
import { ofFrames } from "../../app/web/shared/provenance.js";
import { setOf } from "../../app/web/shared/sets.js";
import { change, openAt, openChapter, state } from "../../app/web/shared/store.js";
import { frames, says } from "./browser.js";

globalThis.history = { state: null, replaceState: () => {} };

test("always naming the largest class has half of two classes right in balance, and is uneven at nine to one", () => {
  assert.deepEqual(
    balance([
      [45, 0],
      [5, 0],
    ]),
    { always: 0.9, balanced: 0.5, uneven: true },
  );
  assert.deepEqual(
    balance([
      [0, 0],
      [0, 0],
    ]),
    { always: 0, balanced: 0, uneven: false },
  );
});

/** A scene after events, each [name, detail, address], or with values in place of an event. */
function sceneAfter(scene, ...events) {
  let now = scene;
  for (const event of events) {
    const next = Array.isArray(event) ? after(now, event[0], event[1], event[2] ?? state) : { ...now, ...event };
    now = Object.freeze(next);
  }
  return now;
}
/** The scene of a set of two pairs, after events. */
const sceneOf = (own, ...events) => sceneAfter(START, ["loaded", { set: "", own, sprite: null, modes: [] }], ...events);
const filtered = ["filtered", {}];

test("no cell of a table starts a formula, and numbers stay numbers", () => {
  assert.deepEqual(["=1+2", "@a", "-1.5", -1.5, "a,b", '=x"'].map(cell), [
    "'=1+2",
    "'@a",
    "-1.5",
    "-1.5",
    '"a,b"',
    `"'=x"""`,
  ]);
});

test("a larger value is a higher tread; a missing one keeps the height of the one before", () => {
  const heights = levels([0.1, 0.9, Number.NaN, 0], [0, 1]);
  assert.ok(heights[1] < heights[0]);
  assert.equal(heights[2], heights[1]);
  assert.ok(heights[3] > heights[0]);
  assert.match(treads(heights), /^M0 [\d.]+H1V[\d.]+H2V[\d.]+H3V[\d.]+H4$/);
});

test("a histogram counts every value once, those at the ends too", () => {
  const counts = histogram([0, 0.5, 1, 2, -1], [0, 1]);
  assert.deepEqual([counts[0], counts[10], counts.at(-1)], [2, 1, 2]);
  assert.equal(histogram([0, 1], [0, 1], (i) => i === 1)[0], 0);
});

test("another set is opened without pins, filters and pairs of the present one", () => {
  const address = new URL(addressOf("chirps", "http://x/?set=sensors&pin=3&domain=a&p=0.5&stage=relu&chapter=analyse"));
  assert.deepEqual(Object.fromEntries(address.searchParams), { set: "chirps", stage: "relu", chapter: "analyse" });
});

test("a filter takes hidden points out of the selection and from the pointer, and is named in the title", () => {
  change({ domain: "A" });
  const scene = sceneOf(frames(), { selected: new Set([0, 1, 2, 3]), hovered: 2 }, filtered);
  assert.deepEqual([[...scene.selected], scene.hovered, [...scene.mask]], [[1, 3], -1, [0, 1, 0, 1]]);
  assert.equal(scenes.loneDomain(scene, state), "B");
  assert.deepEqual(scenes.filtering(scene, state), ["B"]);
  change({ domain: "" });
  assert.deepEqual(scenes.filtering(sceneOf(frames(), filtered), state), []);
});

test("pairs are found by name, class and domain, and look-alikes by what they imitate", () => {
  const pairs = { name: ["bowl-1", "bowl-2"], looks_like: ["", "wood"], feels_like: ["", ""] };
  const unseen = { pairs: { confidence: [0.2, 0.9], cosine: [0, 0] } };
  const scene = sceneOf(frames(), ["learned", { set: "", facts: { pairs, unseen } }]);
  const kept = () => [0, 1].filter(scenes.wantedPoints(scene, state));
  change({ find: "BOWL steel" });
  assert.deepEqual(kept(), [1]);
  change({ find: "", alike: "1" });
  assert.deepEqual(kept(), [1]);
  change({ alike: "", range: "confidence:0.2:0.2" });
  assert.deepEqual(kept(), [0]);
  change({ range: "" });
});

test("another set forgets pointer, selection and facts; a late fact of the set before changes nothing", () => {
  const before = sceneOf(frames(), { hovered: 1, selected: new Set([1]), facts: { pairs: {} } });
  const now = sceneAfter(before, ["loaded", { set: "chirps", own: frames({ pairs: 1 }), sprite: null, modes: [] }]);
  assert.deepEqual([now.hovered, now.selected.size, now.facts.pairs, now.mask.length], [-1, 0, null, 2]);
  assert.deepEqual(sceneAfter(now, ["learned", { set: "", facts: { unseen: {} } }]), now);
});

test("the next point is one that the filters leave, from either end", () => {
  const next = (hovered, by, mask = [1, 0, 0, 1]) => scenes.nextPoint({ mask, hovered }, by);
  assert.deepEqual([next(-1, 1), next(0, 1), next(0, -1), next(1, 1, [0, 0])], [0, 3, 3, 1]);
});

test("a filter under the pointer lights its points, and without one the selection does", () => {
  const scene = sceneOf(frames(), { selected: new Set([2]) });
  const lit = (more) => [0, 1, 2, 3].filter((point) => scenes.lit({ ...scene, ...more }, point));
  assert.deepEqual(lit({}), [2]);
  assert.deepEqual(lit({ selected: new Set() }), [0, 1, 2, 3]);
  assert.deepEqual(lit({ highlight: { kind: "domain", name: "B" } }), [1, 3]);
});

test("a cell in the address selects its pairs by the reading, and one that is not there selects none", () => {
  const pairs = { counts: [1, 1], answers: { fused: [1, 1] } };
  const unseen = { classes: ["wood", "steel"], source: "A", confusion: { fused: { unseen: [], B: [] } }, pairs };
  const scene = sceneOf(frames(), ["learned", { set: "", facts: { unseen } }]);
  const cell = (cell) => sceneAfter(scene, ["cellFollowed", {}, { cell, reading: "fused" }]).cell;
  assert.deepEqual(cell("1~1~unseen").pairs, new Set([1]));
  assert.equal(cell("1~1~B").words, "steel predicted as steel");
  assert.deepEqual(cell("0~1~unseen").pairs, new Set()); // the source is no stranger
  for (const none of ["", "7~1~unseen", "1~1~Z"]) assert.equal(cell(none), null);
});

test("neighbours are those of the pinned pair at this step and p, and of no other", () => {
  const address = { pin: 1, stage: "f_hat" };
  const points = [{ point: 0, cosine: 0.5 }];
  const key = scenes.nearKey(sceneOf(frames()), address);
  const scene = sceneOf(frames(), ["arrived", { nearest: { key, points } }]);
  assert.equal(scenes.near(scene, address), points);
  assert.deepEqual(scenes.near({ ...scene, stop: 2 }, address), []); // of another p
  assert.deepEqual(scenes.near(scene, { ...address, pin: 0 }), []);
  says(neighboursHtml(points, scene), /title="photo of pair 0, wood, A, cosine 0\.500"/);
});

test("neighbours in frames of other heads than the loaded one are those of the raw embedding, and say so", () => {
  for (const foreign of [false, true]) {
    const shown = frames({ foreign, prediction: [0, 1, 0, 1, 0, 1], confidence: [] });
    assert.equal(scenes.nearStage({ frames: shown }, { stage: "f_hat" }), foreign ? "raw" : "f_hat");
    assert.equal(String(card(shown, null, 1, 0, true)).includes("raw embedding"), foreign);
  }
});

test("an accuracy names its head, and a learned p is not a round one", () => {
  const accuracy = { "accuracy/unseen": [0.3, 0.6, 0.4] };
  const learned = frames({ head: { learned_order: 0.5 }, curves: accuracy });
  const by = (of, stop) => String(ofFrames(of, stop, "2 pairs")).replaceAll("\u00a0", " ");
  assert.match(
    by(learned, 1),
    /loaded head at its learned p = 0\.50, trained on A and tested on 2 pairs\. The model was given nothing from/,
  );
  const near = frames({ head: { learned_order: 0.5035 }, orders: [0, 0.5, 0.5035], curves: accuracy });
  assert.match(by(near, 1), /the loaded head, changed to p = 0\.50,/);
  assert.match(by(near, 2), /its learned p = 0\.503/);
  says(headOf(frames({ head: { source: "Z" } }), 1), /trained on Z, which is not in this set/);
});

test("the chapter of the order speaks of p only as far as the accuracy bears", () => {
  const at = (share, stop = 1) =>
    LESSONS.order.words(sceneOf(frames({ curves: { "accuracy/unseen": share } }), { stop }));
  assert.match(at([0.3, 0.9, 0.4]).title, /^At one value of p, two kinds/);
  assert.match(at([0.6, 0.62, 0.61]).title, /hardly changes accuracy/);
  assert.doesNotMatch(at(null).title, /matters/);
  const flat = frames({ curves: { "accuracy/unseen": [0.6, 0.61, 0.6] }, head: { learned_order: 0.5 } });
  assert.equal(startOf("order", flat, flat), 0.5);
});

test("no winner is named where two intervals overlap", () => {
  const share = (share, low, high) => ({ share, low, high });
  const unseen = (vis, tac) => ({
    domains: [{ pairs: 100 }],
    unseen: { "answers/fused": share(0.5, 0.4, 0.6) },
    look_alikes: { pairs: 20, "answers/vis": vis, "answers/tac": tac },
  });
  const words = (vis, tac) => `${LESSONS.fooled.words({ own: frames(), facts: { unseen: unseen(vis, tac) } }).remark}`;
  assert.match(words(share(0.2, 0.1, 0.3), share(0.5, 0.4, 0.6)), /the touch alone is correct more often/);
  assert.match(words(share(0.4, 0.2, 0.6), share(0.5, 0.3, 0.7)), /overlap/);
});

test("a confidence is a colour only where it has a temperature", () => {
  const keys = (kind) => colouringsOf(frames({ kind })).map(({ id }) => id);
  assert.ok(keys("moved").includes("confidence"));
  for (const kind of ["retrained", "every"]) assert.ok(!keys(kind).includes("confidence"));
  assert.equal(colouring(frames({ kind: "retrained" }), "confidence").title, "Class");
});

test("a selection comes back from its text, and what is no selection selects nothing", () => {
  assert.equal(scenes.packed([7, 5, 6, 9]), "5.7-9");
  for (const points of [[], [0], [5, 6, 7, 40, 41, 99], [0, 1, 2, 3]])
    assert.deepEqual(scenes.unpacked(scenes.packed(new Set(points)), 100), points);
  const scattered = Array.from({ length: 900 }, (_, i) => (i * 389) % 3840);
  assert.ok(scenes.packed(scattered).length < 700);
  assert.deepEqual(
    scenes.unpacked(scenes.packed(scattered), 3840),
    scattered.toSorted((a, b) => a - b),
  );
  assert.equal(scenes.packed(Array.from({ length: 9000 }, (_, i) => 7 * i)), "");
  for (const junk of ["zz.zz", "98.100-99", "~%%%", "~ab=c"]) assert.deepEqual(scenes.unpacked(junk, 100), []);
});

test("tags are saved and loaded by CSV; formulas are texts there, and another file is refused", () => {
  const shown = frames({ meta: { embeddings: {}, head: {} } });
  tagPairs(shown, [0, 1], '=odd, "new"');
  const text = tagsCsv(shown, ["a", "b"]);
  assert.match(text, /"'=odd, ""new"""/);
  tagPairs(shown, [0, 1], "");
  assert.equal(tagOf(shown, 0), "");
  assert.equal(loadTags(shown, text), 2);
  assert.equal(tagOf(shown, 1), '=odd, "new"');
  assert.throws(() => loadTags(shown, "x,y\n1,2"), /no columns 'pair' and 'tag'/);
});

test("the chapter of the order shows the chirps, the others the set of the page or the sensors", () => {
  const sets = (shown) => ["sensors", "chirps"].map((name) => ({ name, shown: name === shown }));
  for (const [chapter, listed, wanted] of [
    ["order", sets("sensors"), "chirps"],
    ["gaps", sets("chirps"), ""],
    ["fooled", sets("chirps"), "sensors"],
    ["order", [], ""],
  ])
    assert.equal(setOf(chapter, listed), wanted, chapter);
});

test("a range of a histogram is named with its ends, so that titles and captions tell what is hidden", () => {
  change({ range: "cosine:0.2:0.4~junk:1:2~confidence:x:1~confidence:0.5" });
  assert.deepEqual(scenes.filtering(sceneOf(frames()), state), ["photo–touch cosine 0.20 to 0.40"]);
  assert.deepEqual(scenes.rangesOf(state), { cosine: [0.2, 0.4] });
  change({ range: "" });
});

test("a range is kept with four digits beside the others, and one that keeps all pairs is left out", () => {
  assert.equal(ranged("cosine:0.2:0.4", "confidence", [0, 1], [0.12345, 1]), "cosine:0.2:0.4~confidence:0.1235:1");
  assert.equal(ranged("cosine:0.2:0.4", "cosine", [0, 1], [0, 1]), "");
  assert.equal(ranged("cosine:0.2:0.4", "cosine", [0, 1], null), "");
});

test("both ends of a range move by keys, and neither passes the other or leaves the histogram", () => {
  for (const [range, by, upper, wanted] of [
    [undefined, 1, false, [0.05, 1]],
    [[0.5, 0.52], 3, false, [0.52, 0.52]],
    [[0.5, 1], 1, true, [0.5, 1]],
  ])
    assert.deepEqual(shifted(range, [0, 1], by, upper), wanted);
});

const twins = { domains: [{ name: "A-sim" }, { name: "B-sim" }], pictures: [5, 20], shown: [{ class: 0 }] };

test("the page opens with the press that is read best once its dots are filled, and that looks like what it is", () => {
  const made = {
    domains: twins.domains,
    shown: [{ class: 0 }, { class: 0 }, { class: 0, looks_like: "steel" }],
    verdicts: { touch: [[["011111"], ["010000"]]] },
  };
  assert.equal(pressOf(made, { press: "" }), 1);
});

test("an address that names no press, sensor or number of pictures opens with the first", () => {
  openChapter("touch");
  change({ from: "99", press: "-1", known: "7", dots: "", reading: "fused" });
  assert.deepEqual(chosen(twins, state), { reading: "fused", table: "both", press: 0, from: 0, look: 0, rung: 0 });
  change({ from: "0", press: "", known: "0", reading: "tac" });
});

test("what is lost leads from home to away, and a term that does not apply has no row", () => {
  const loss = {
    home: [80, 70, 90],
    sensor: [24, 14, 34],
    scene: [0, 0, 0],
    interplay: [0, 0, 0],
    objects: [-4, -9, 1],
    away: [60, 50, 70],
  };
  const rows = barsOf(loss);
  assert.deepEqual(
    rows.map(({ name, text, ends }) => [name, text, ...ends.map((v) => v.toFixed(2))]),
    [
      ["training domain", "80\u00a0%", "0.00", "0.80"],
      ["another sensor", "−24", "0.56", "0.80"],
      ["other objects", "+4", "0.56", "0.60"],
      ["new domain", "60\u00a0%", "0.00", "0.60"],
    ],
  );
  const odd = {
    home: [74.4, 0, 0],
    sensor: [10.4, 0, 0],
    scene: [1.4, 0, 0],
    interplay: [5.4, 0, 0],
    objects: [0.4, 0, 0],
  };
  const shown = barsOf({ ...odd, away: [56.8, 0, 0] }).map(({ text }) => +text.replace("−", "-").replace(/\D*%/, ""));
  assert.equal(
    shown.at(-1),
    shown.slice(0, -1).reduce((sum, v) => sum + v),
  ); // the figures add up
});

test("in the chapter of the order the stops between which p was dragged are kept, by frames", () => {
  const own = frames();
  const at = (p, chapter = "order") => ["moved", {}, { p, chapter }];
  const begun = sceneOf(own, at(1));
  assert.deepEqual([begun.stop, begun.dragged.get(own), scenes.whole(begun)], [2, [2, 2], false]);
  assert.equal(sceneAfter(begun, at(0, "analyse")).dragged, begun.dragged);
  const all = sceneOf(own, at(1), at(0));
  assert.deepEqual([all.stop, all.dragged.get(own), scenes.whole(all)], [0, [0, 2], true]);
});

test("the map of the last chapter follows the reading: its points, its predictions, its colours", () => {
  openChapter("fooled", { reading: "tac" });
  const own = frames({ prediction: [0, 1, 0, 1, 0, 1] });
  const unseen = { pairs: { answers: { tac: [1, 1] } } };
  const scene = sceneOf(own, ["learned", { set: "", facts: { unseen } }]);
  const first = () => {
    const coloured = scenes.painted(scene, state);
    return colouring(coloured, "correctness").of(coloured, 0)(0);
  };
  const mask = () => [...sceneAfter(scene, filtered).mask];
  assert.deepEqual([mask(), first()], [[0, 0, 1, 1], 1]);
  change({ reading: "fused" });
  assert.deepEqual([mask(), first()], [[1, 1, 1, 1], 0]);
  assert.equal(own.answered, null);
  openChapter("analyse");
});

test("look-alikes are scored pairs of unseen domains, one of each class, where the photo alone misleads first", () => {
  const own = frames({ pairs: 5, domain: [0, 1, 1, 1, 1], label: [0, 1, 1, 0, 0] });
  const facts = {
    unseen: {
      source: "A",
      pairs: { counts: [1, 1, 1, 1, 1], answers: { vis: [0, 0, 0, 0, 1], tac: [0, 0, 1, 0, 1] } },
    },
    pairs: { looks_like: ["steel", "wood", "wood", "", "steel"] },
  };
  assert.deepEqual(lookAlikes({ frames: own, facts }), [2, 4]);
});

test("p of the chapter of the order waits while another tab is open", () => {
  change({ view: "pair" });
  openChapter("order", { p: null }); // as a link to the tab does before Explore is ready
  openAt(0.8);
  assert.equal(state.p, null);
  change({ view: "explore" });
  assert.equal(state.p, 0.8);
});

test("a set of one domain is coloured by class", () => {
  const one = frames({ domain: [1, 1], curves: { "accuracy/unseen": [0.5, 0.5, 0.5] } });
  assert.equal(colouring(one, "domain").title, "Class");
  assert.equal(colouring(frames(), "domain").title, "Domain");
});

test("while stops are still computed they are dots on the whole axis, and no line joins them", () => {
  const scale = new Scale({ wide: 200, high: 100, pad: { left: 0, right: 0, top: 0, bottom: 0 }, xs: [0, 1] });
  const path = (coarse) => line([0.2, 0.8], scale, frames({ orders: [0, 0.5], coarse }));
  assert.match(path(false), /L/);
  assert.match(path(true), /^M0 [^L]*h\.01M100 [^L]*h\.01$/); // the last stop that is ready stands in the middle
});

test("a map is as wide as the points that it shows, whatever the bounds of its numbers", () => {
  const bounds = [
    [-3.5, -3.5],
    [2.5, 2.5],
  ]; // the data lie from 0.25 to 0.5 of them
  const extents = [
    [16384, 16384, 32768, 32768],
    [16384, 16384, 32768, 32768],
  ];
  const view = { zoom: 1, dx: 0, dy: 0 };
  const map = { frame: { bounds, extents }, halves: [true, true], top: 0, width: 500, height: 500, view };
  const { ax, bx } = Cloud.prototype.transform.call(map);
  assert.ok(Math.abs(16384 * ax + bx - 30) < 1 && Math.abs(32768 * ax + bx - 470) < 1);
});
