/** Try a pair: what it says, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { about } from "../../app/web/pair/attention.js";
import { sentence } from "../../app/web/pair/familiar.js";
import { changed, told } from "../../app/web/pair/hidden-parts.js";
import { spread } from "../../app/web/pair/lines.js";
import { aboutP, band } from "../../app/web/pair/orders.js";
import { keyOf, lessonsFor, missing, tally, withoutPair, withPair } from "../../app/web/pair/tally.js";
import { cards, classTable, judged, madeOf } from "../../app/web/pair/verdict.js";

const CLASSES = ["wood", "steel"];
const PAIR = {
  classes: CLASSES,
  exact: {
    readings: {
      fused: [0.9, 0.1],
      vis: [0.8, 0.2],
      tac: [0.3, 0.7],
      vis_branch: [0.9, 0.1],
      tac_branch: [0.85, 0.15],
    },
  },
};
const LABELLED = [
  { vis: "image:a", tac: "image:b", label: "wood", said: { fused: "wood", vis: "wood", tac: "steel" } },
  { vis: "image:c", tac: null, label: "steel", said: { vis: "wood" } },
];

test("touch only is the touch with the photo absent, never a branch inside the pair", () => {
  const html = cards(PAIR, { images: {} }, {});
  const touch = html.slice(html.indexOf('data-reading="tac"'));
  assert.match(touch, /steel <b>70/);
  assert.ok(!html.includes("85"));
});

test("an image unlike the training images makes every reading that uses it a guess, without a figure", () => {
  const html = cards(PAIR, { images: { vis: { guess: true }, tac: { guess: false } } }, {});
  const [both, photo, touch] = html.split("<article").slice(1);
  for (const guessed of [both, photo]) {
    assert.match(guessed, /This is a guess/);
    assert.match(guessed, /The photo is unlike anything it has seen/);
    assert.ok(!guessed.includes("%"));
  }
  assert.match(touch, /steel <b>70/);
});

test("with one image there is no reading of both", () => {
  const html = cards(
    { classes: CLASSES, exact: { readings: { fused: [0.3, 0.7], tac: [0.3, 0.7] } } },
    null,
    {},
  );
  assert.match(html, /Add the photo to see both together/);
  assert.match(html, /No photo here/);
});

test("a prediction is judged by the class of the images that it used", () => {
  assert.match(judged("wood", ["vis"], { vis: "wood", tac: "steel" }, CLASSES), /right/);
  assert.match(judged("wood", ["tac"], { vis: "wood", tac: "steel" }, CLASSES), /it is steel/);
  assert.match(judged("wood", ["vis", "tac"], { vis: "wood", tac: "steel" }, CLASSES), /follows the photo/);
  assert.match(judged("wood", ["vis"], { vis: "cork" }, CLASSES), /a class this head has not learned/);
  assert.equal(judged("wood", ["vis"], {}, CLASSES), "");
});

test("names from files cannot become markup", () => {
  assert.ok(!madeOf({ vis: "<img>", tac: "steel" }).includes("<img>"));
  assert.ok(!classTable(["<b>", "steel"], { fused: [1, 0], vis: [1, 0] }).includes("<b>"));
});

test("familiarity is said in words and as a share of the training images", () => {
  const image = { words: "unlike the training images", quantile: 0.01 };
  assert.equal(
    sentence("vis", image),
    "Unlike the training images: 99\u00a0% of the training photos have a closer neighbour.",
  );
  assert.match(sentence("vis", { words: "familiar", quantile: 1, cosine: 1 }), /one of the training photos/);
  assert.match(sentence("tac", {}), /has no record/);
});

test("each reading is counted over the pairs that had its images", () => {
  assert.deepEqual(tally(LABELLED), {
    fused: { right: 1, of: 1 },
    vis: { right: 1, of: 2 },
    tac: { right: 0, of: 1 },
  });
});

test("teaching waits for two pairs of each of two classes and names what is there", () => {
  assert.match(missing([]), /none yet/);
  assert.match(missing(LABELLED), /wood 1, steel 1/);
  assert.equal(missing([...LABELLED, ...LABELLED]), "");
});

test("a pair is never predicted from its own label", () => {
  assert.deepEqual(lessonsFor(LABELLED, LABELLED[0]), [{ vis: "image:c", tac: null, label: "steel" }]);
});

test("a pair labelled again keeps its last label", () => {
  const again = withPair(LABELLED, { ...LABELLED[0], label: "steel" });
  assert.equal(again.length, 2);
  assert.equal(again.at(-1).label, "steel");
  assert.equal(withoutPair(again, keyOf(LABELLED[1])).length, 1);
});

test("labels at the ends of lines stay inside the chart and apart", () => {
  for (const ends of [[5, 5, 5], [240, 241, 242, 243], Array.from({ length: 40 }, () => 100)]) {
    const places = spread(ends, 10, 220);
    const sorted = [...places].sort((a, b) => a - b);
    assert.ok(sorted[0] >= 10 - 1e-9 && sorted.at(-1) <= 220 + 1e-9, String(places));
    for (let i = 1; i < sorted.length; i++)
      assert.ok(sorted[i] - sorted[i - 1] >= Math.min(14, 210 / (ends.length - 1)) - 1e-9);
  }
});

test("parts that change nothing are not shown", () => {
  const nothing = changed([[0.004, -0.001]]);
  assert.equal(nothing.any, false);
  assert.match(told({ class: "wood", probability: 0.5 }, nothing), /no single part matters/);
  const some = changed([[0.2, 0]]);
  assert.match(
    told({ class: "wood", probability: 0.5 }, some),
    /orange supports <i>wood<\/i>\. Hiding a part changes its probability by at most 20/,
  );
});

test("uniform attention is a sentence", () => {
  assert.match(about(8, 0.001), /Nothing to see: each of the 8 tokens gets the uniform 12\.5 %/);
  assert.match(about(8, 0.2), /Rows attend to columns/);
});

test("the band is what the head was trained for", () => {
  assert.deepEqual(
    band([0.5, 0.5]).map((p) => +p.toFixed(2)),
    [0.47, 0.53],
  );
  assert.deepEqual(band([0, 1]), [0, 1]);
  assert.match(aboutP(0.5, [0.5, 0.5], CLASSES), /guessing \(50/);
  assert.match(aboutP(0.5, [0, 1], CLASSES), /trained for every p/);
});
