import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import "./browser.js";
import { firstPair, headIn, headText, pairOf, rowOf } from "../../app/web/explore/gap-pair.js";
import { Frames } from "../../app/web/shared/frames.js";
import { verdictOn } from "../../app/web/shared/gap-words.js";
import { GAPS } from "../../app/web/shared/measures.js";
import { starAt } from "../../app/web/shared/pair-marks.js";
import { treeSvg } from "../../app/web/shared/pair-tree.js";
import { says } from "./browser.js";

const shipped = (name) => {
  const bytes = readFileSync(new URL(`../../examples/${name}`, import.meta.url));
  return Frames.in(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};
const FRAMES = shipped("frames.bin");
const text = (markup) => String(markup).replace(/<[^>]*>/g, "");

/** Frames at three stops whose gaps are the same at each step but for the output. */
function gapsOf(raw, projected, output) {
  const steps = { raw, frft: projected, relu: projected, f_bar: projected };
  const curves = GAPS.flatMap(({ id }) => [
    ...Object.entries(steps).map(([step, v]) => [`${id}/${step}`, [v, v, v]]),
    [`${id}/f_hat`, output],
  ]);
  const maps = { "pca/raw": { array: 1, orders: [0] }, "pca/frft": { array: 2, orders: [0] } };
  return { orders: [0, 0.5, 1], meta: { curves: Object.fromEntries(curves), maps } };
}

test("p closes a gap that falls more from the worst p to the best than from the embedding to the worst", () => {
  for (const [frames, wanted, pattern] of [
    [
      gapsOf(0.5, 0.3, [0.1, 0.13, 0.11]),
      "No: the steps of the head close them.",
      /between 0.10 and 0.13.*at the projection\./,
    ],
    [gapsOf(0.5, 0.5, [0.4, 0.1, 0.45]), "Yes, for this head.", /0.10 at p = 0.50 and 0.45 at p = 1.00/],
    [gapsOf(0.1, 0.1, [0.2, 0.3, 0.4]), "No, and neither do the steps.", /0.20 at p = 0.00/],
    [gapsOf(0.5, 0.2, [0.1, 0.1, 0.1]), "No: the steps of the head close them.", /stays at 0.10/],
  ]) {
    const { answer, words } = verdictOn(frames);
    assert.equal(answer, wanted);
    assert.match(text(words), pattern);
  }
  assert.equal(verdictOn({ ...gapsOf(0, 0, []), meta: { curves: {}, maps: {} } }), null);
});

test("frames at some stops have the values, predictions and maps of these stops", () => {
  const stops = FRAMES.meta.maps["umap/f_hat"].orders;
  const some = FRAMES.only(stops);
  assert.equal(some.whole, FRAMES);
  for (const at of [0, 7, 20]) {
    const stop = stops[at];
    assert.equal(some.orders[at], FRAMES.orders[stop]);
    assert.equal(some.meta.curves["domain_gap/f_hat"][at], FRAMES.meta.curves["domain_gap/f_hat"][stop]);
    assert.equal(some.prediction[at * some.pairs + 9], FRAMES.prediction[stop * FRAMES.pairs + 9]);
    const [now, before] = [some.positions("umap", "f_hat", at), FRAMES.positions("umap", "f_hat", stop)];
    assert.equal(now.drawn, at);
    assert.deepEqual(now.points.slice(0, 40), before.points.slice(0, 40));
  }
});

test("the pair is that of the address, else the pinned one of another set, else the one to open with", () => {
  const nothing = { vis: null, tac: null, pin: null };
  const scene = { set: "", frames: FRAMES, opening: null };
  const first = `row:${firstPair(FRAMES)}`;
  assert.notEqual(FRAMES.domains[FRAMES.domain[firstPair(FRAMES)]], FRAMES.source);
  assert.deepEqual(pairOf(scene, nothing), { vis: first, tac: first });
  assert.deepEqual(pairOf({ ...scene, opening: "example:a" }, nothing).vis, "example:a");
  assert.deepEqual(pairOf(scene, { ...nothing, vis: "image:1" }), { vis: "image:1", tac: null });
  assert.deepEqual(pairOf({ ...scene, set: "chirps" }, { vis: "image:1", tac: null, pin: 4 }).tac, "row:4");
});

test("an example is the row of its name, class and domain; other pictures are no row", () => {
  const name = Array.from(FRAMES.label, (_, pair) => `${pair}`);
  const scene = { frames: FRAMES, facts: { pairs: { name } } };
  const example = `example:${FRAMES.domains[FRAMES.domain[1200]]}/${FRAMES.classes[FRAMES.label[1200]]}/1200`;
  const both = (ref) => ({ vis: ref, tac: ref });
  assert.equal(rowOf(scene, both(example)), 1200);
  assert.equal(rowOf(scene, both("row:7")), 7);
  for (const pair of [both("row:99999"), both("image:x"), { vis: "row:1", tac: "row:2" }, { vis: "row:1" }])
    assert.equal(rowOf(scene, pair), -1);
});

test("a head in the address keeps its set, its mode or its name, and an unknown set is the page's own", () => {
  const sets = [{ name: "sensors", shown: true }, { name: "chirps" }];
  for (const of of [
    { set: "", mode: "retrained", head: "" },
    { set: "chirps", mode: "moved", head: "" },
    { set: "", mode: "moved", head: "mine" },
  ])
    assert.deepEqual(headIn({ by: headText(of) }, sets), of);
  assert.equal(headText({ set: "", mode: "moved" }), "");
  assert.equal(headIn({ by: "elsewhere/moved" }, sets).set, "");
});

test("the tree has a star for each node with its prediction, and a star is found at the pointer", () => {
  const probabilities = [Array.from({ length: 7 }, (_, i) => (i % 2 ? [0.9, 0.1] : [0.2, 0.8]))];
  const tree = { parents: [-1, 0, 0, 1, 1, 2, 2], probabilities, in_use: true };
  const svg = treeSvg({ classes: ["wood", "steel"], tree }, 0);
  assert.equal(String(svg).match(/<polygon/g).length, 7);
  assert.equal(String(svg).match(/class="edge"/g).length, 6);
  says(svg, /Node 1 alone predicts steel, 80/, /Node 2 alone predicts wood, 90/);
  const nodes = [[Number.NaN, 0], [100, 0]]; // biome-ignore format: one line
  assert.deepEqual([starAt(nodes, [104, 3]), starAt(nodes, [50, 0])], [1, -1]);
});
