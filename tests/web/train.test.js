/** Train here: what it says and draws, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { chart, charts, niceTop } from "../../app/web/train/lines.js";
import { chosen, compared, formHtml, inWords, mapAt, measuredAt, result, standing } from "../../app/web/train/plan.js";

const OFFERS = {
  sources: ["TAG-sim", "<OF>"],
  widths: [16, 64],
  orders: ["gradient", "fixed", "search", "every"],
  ranges: {
    p: [0, 1],
    mma: [0, 50],
    levels: [1, 5],
    expansion: [1, 8],
    noise: [0, 5],
    shift: [0, 2],
    epochs: [5, 100],
    seed: [0, 999],
  },
  first: {
    source: "TAG-sim",
    width: 64,
    order: "gradient",
    lang: true,
    p: 0.5,
    mma: 10,
    levels: 3,
    expansion: 4,
    noise: 0,
    shift: 0,
    epochs: 40,
    seed: 0,
  },
};
const EPOCHS = [
  { epoch: 1, loss: 2, cross_entropy: 1.5, order: 0.5, measures: { "accuracy/unseen": 0.3 }, map: "AA==" },
  { epoch: 2, loss: 1, cross_entropy: 0.7, order: 0.51, measures: {}, map: null },
];

test("the form offers what the server offers and cannot carry markup", () => {
  const html = formHtml(OFFERS);
  assert.match(html, /learn p by gradient/);
  assert.match(html, /name="epochs" min="5" max="100"/);
  assert.ok(!html.includes("<OF>"));
});

test("the form becomes a question of numbers", () => {
  const entries = [
    ["source", "TAG-sim"],
    ["width", "64"],
    ["order", "fixed"],
    ["p", "0.3"],
    ["mma", "10"],
    ["levels", "3"],
    ["expansion", "4"],
    ["noise", "2"],
    ["shift", "1"],
    ["epochs", "40"],
    ["seed", "1"],
  ];
  const question = chosen(entries);
  assert.deepEqual([question.width, question.p, question.lang], [64, 0.3, false]);
  assert.equal(
    inWords(question),
    "TAG-sim, D = 64, keep p fixed = 0.3, λ = 10, R = 3, E = 4, noise 2, imitated sensors 1, no LANG, seed 1",
  );
});

test("a waiting training tells its place, a running one its epoch", () => {
  const at = { epochs: 0, total: 40 };
  assert.match(standing({ state: "waiting", place: 2, text: "", problem: "" }, at), /place 2 in the queue/);
  assert.equal(
    standing({ state: "running", place: 0, text: "searching p", problem: "" }, at),
    "Starting: searching p.",
  );
  assert.equal(
    standing({ state: "running", place: 0, text: "epoch 3", problem: "" }, { epochs: 3, total: 40 }),
    "Training: epoch 3 of 40.",
  );
  assert.equal(standing({ state: "failed", place: 0, text: "", problem: "The loss is nan." }, at), "The loss is nan.");
});

test("pairs without a class are counted as left out while a training waits, runs and ends", () => {
  const at = { epochs: 40, total: 40, leftOut: 12 };
  assert.match(standing({ state: "waiting", place: 2 }, at), /12 pairs without a class are left out\.$/);
  assert.equal(standing({ state: "done" }, at), "Done: 40 epochs. 12 pairs without a class are left out.");
  assert.match(standing({ state: "done" }, { ...at, leftOut: 1 }), /1 pair without a class is left out\.$/);
  assert.equal(standing({ state: "failed", problem: "The loss is nan." }, at), "The loss is nan.");
});

test("scrubbing back shows the newest map and measures up to that epoch", () => {
  assert.deepEqual(mapAt(EPOCHS, 2), { map: "AA==", epoch: 1 });
  assert.equal(mapAt(EPOCHS, 0), null);
  assert.deepEqual(measuredAt(EPOCHS, 2), { "accuracy/unseen": 0.3 });
  assert.equal(result(EPOCHS).unseen, "30.0\u00a0%");
});

test("an axis ends at a round figure above all values", () => {
  assert.deepEqual([0.04, 0.9, 2.1, 7].map(niceTop), [0.05, 1, 2.5, 10]);
});

test("values stay inside the chart and missing measures leave no gap in the page", () => {
  const svg = chart({
    title: "t",
    total: 2,
    at: 1,
    series: [
      {
        name: "a",
        colour: "red",
        points: [
          [1, 0],
          [2, 3],
        ],
      },
    ],
  });
  const heights = [...svg.matchAll(/[ML][\d.]+ ([\d.]+)/g)].map((found) => +found[1]);
  assert.ok(heights.every((y) => y >= 0 && y <= 120));
  assert.match(charts(EPOCHS, 40, 2, 5), /unseen domains <b>30\.0 %/);
});

test("the form shows three controls; the rest is under Advanced", () => {
  const [first, advanced] = formHtml(OFFERS).split("<details");
  assert.deepEqual(first.match(/<(select|input|button type="submit")/g), [
    "<select",
    "<select",
    '<button type="submit"',
  ]);
  assert.equal(advanced.match(/<(select|input)/g).length, 10);
});

test("two runs are compared, and one is not", () => {
  const runs = [{ share: 0.5 }, { share: 0.512 }];
  assert.match(compared(runs), /1\.2 points above the one before it\. Train .* other seeds/);
  assert.match(compared(runs.toReversed()), /1\.2 points below/);
  assert.equal(compared(runs.slice(1)), "");
});

test("once anything is measured, a chart without a value is left out; before, it waits", () => {
  const titles = (epochs) => [...charts(epochs, 40, 1, 5).matchAll(/<figcaption>([^<]+)/g)].map(([, title]) => title);
  const measures = { "modality_gap/f_hat": 0.3, "margin/f_hat": 0.1 }; // of a set of one domain
  assert.equal(titles([{ ...EPOCHS[0], measures: {} }]).length, 6);
  assert.deepEqual(titles([{ ...EPOCHS[0], measures }]), ["Loss", "Gaps of F̂", "Cosine margin of F̂", "p"]);
});
