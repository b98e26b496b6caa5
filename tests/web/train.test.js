/** Train here: what it says and draws, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { chart, charts, niceTop } from "../../app/web/train/lines.js";
import { chosen, compared, formHtml, mapAt, result, standing } from "../../app/web/train/plan.js";
import { active, FIRST, next } from "../../app/web/train/state.js";

const OFFERS = {
  sources: ["TAG-sim", "<OF>"],
  widths: [16, 64],
  orders: [["gradient", "learn p by gradient"]],
  numbers: [{ name: "epochs", words: "epochs", least: 5, most: 100, step: 1 }],
  first: { source: "TAG-sim", width: 64, order: "gradient", lang: true, epochs: 40 },
};
const EPOCHS = [
  { epoch: 1, loss: 2, cross_entropy: 1.5, order: 0.5, measures: { "accuracy/unseen": 0.3 }, map: "AA==" },
  { epoch: 2, loss: 1, cross_entropy: 0.7, order: 0.51, measures: {}, map: null },
];
const FRAME = { at: 2, total: 40 };
const started = { run: "a", total: 40, left_out: 0 };
const run = (state, { epochs = [], ...more } = {}, leftOut = 0) => ({
  started: { ...started, left_out: leftOut },
  epochs,
  standing: { state, place: 0, text: "", left: "", problem: "", ...more },
});
const after = (...events) => events.reduce(next, FIRST);
const START = { kind: "started", started, question: OFFERS.first };
const news = (state, epochs = [], name = "a") => ({ kind: "news", run: name, reply: { state, epochs } });

test("a run takes its epochs and shows the newest, until an earlier one is looked at", () => {
  const one = after({ kind: "asked" }, START, news("running", EPOCHS.slice(0, 1)));
  assert.deepEqual([one.at, one.busy, active(one.run)], [1, true, true]);
  const back = after(START, news("running", EPOCHS), { kind: "looked", at: 1 }, news("running", [{ epoch: 3 }]));
  assert.deepEqual([back.at, back.run.epochs.length], [1, 3]);
  const newest = [back, { kind: "looked", at: 3 }, news("running", [{ epoch: 4 }])].reduce((s, event) =>
    next(s, event),
  );
  assert.equal(newest.at, 4);
});

test("Train can be pressed again once a run has ended or was refused", () => {
  for (const end of ["done", "failed", "cancelled"]) {
    const over = after({ kind: "asked" }, START, news(end, EPOCHS));
    assert.deepEqual([over.busy, active(over.run), over.earlier.length], [false, false, Number(end === "done")]);
  }
  const refused = after({ kind: "asked" }, { kind: "refused", problem: "Cancel it first." });
  assert.deepEqual([refused.busy, refused.problem], [false, "Cancel it first."]);
  assert.equal(next(refused, { kind: "asked" }).problem, "");
});

test("a refused second run leaves the first on the screen, and news of a run that was left is ignored", () => {
  const first = after(START, news("running", EPOCHS));
  const refused = next(next(first, { kind: "asked" }), { kind: "refused", problem: "Cancel it first." });
  assert.equal(refused.run, first.run);
  const second = next(first, { ...START, started: { ...started, run: "b" } });
  assert.deepEqual([second.at, second.run.epochs], [0, []]);
  assert.equal(next(second, news("done", EPOCHS)), second);
});

test("the form offers what the server offers, three controls first, and cannot carry markup", () => {
  const [first, advanced] = String(formHtml(OFFERS)).split("<details");
  assert.match(first, /learn p by gradient/);
  assert.ok(!first.includes("<OF>"));
  assert.deepEqual(first.match(/<select|<input|submit/g), ["<select", "<select", "submit"]);
  assert.match(advanced, /name="epochs" min="5" max="100" step="1" value="40"/);
  assert.equal(advanced.match(/<(select|input)/g).length, 3);
});

test("the form becomes a question of numbers", () => {
  const question = chosen(Object.entries({ source: "TAG-sim", width: "64", order: "fixed", p: "0.3" }));
  assert.deepEqual(question, { source: "TAG-sim", width: 64, order: "fixed", p: 0.3, lang: false });
});

test("a training tells its place or its epoch, its end, and how many pairs have no class", () => {
  const third = { text: "epoch 3", left: "9 s left", epochs: [1, 2, 3] };
  for (const [state, words, more, leftOut] of [
    ["waiting", "Waiting."],
    ["waiting", /place 2 in the queue.* 12 pairs without a class are left out\.$/, { place: 2 }, 12],
    ["running", "Starting: searching p.", { text: "searching p" }],
    ["running", "Training: epoch 3 of 40, 9 s left.", third],
    ["running", "Calibrating probabilities on held-out pairs.", { epochs: Array(40) }],
    ["failed", "The loss is nan.", { problem: "The loss is nan." }, 12],
    ["cancelled", "Cancelled after 1 of 40 epochs.", { epochs: [1] }],
    ["done", "Done: 40 epochs. 1 pair without a class is left out.", {}, 1],
  ]) {
    const found = standing(run(state, more, leftOut));
    if (words instanceof RegExp) assert.match(found, words);
    else assert.equal(found, words);
  }
});

test("scrubbing back shows the newest map up to that epoch, and a result the newest measures", () => {
  assert.equal(mapAt(EPOCHS, 2), "AA==");
  assert.equal(mapAt(EPOCHS, 0), null);
  assert.deepEqual(result(run("done", { epochs: EPOCHS })), ["0.510", "30.0\u00a0%", "–", "–"]);
});

test("an axis ends at a round figure above all values", () => {
  assert.deepEqual([0.04, 0.9, 2.1, 7].map(niceTop), [0.05, 1, 2.5, 10]);
});

test("values stay inside the chart and missing measures leave no gap in the page", () => {
  const points = [
    [1, 0],
    [2, 3],
  ];
  const svg = String(chart("t", [{ name: "a", colour: "red", points }], { total: 2, at: 1 }));
  const heights = [...svg.matchAll(/[ML][\d.]+ ([\d.]+)/g)].map((found) => +found[1]);
  assert.ok(heights.length === 2 && heights.every((y) => y >= 0 && y <= 120));
  assert.match(String(charts(EPOCHS, 5, FRAME)), /unseen domains <b>30\.0\s%/);
});

test("two runs are compared, and one is not", () => {
  const runs = [0.5, 0.512].map((share) => run("done", { epochs: [{ measures: { "accuracy/unseen": share } }] }));
  assert.match(compared(runs), /1\.2 points above the one before it\. Train .* other seeds/);
  assert.match(compared(runs.toReversed()), /1\.2 points below/);
  assert.equal(compared(runs.slice(1)), "");
});

test("once anything is measured, a chart without a value is left out; before, it waits", () => {
  const titles = (epochs) =>
    [...String(charts(epochs, 5, FRAME)).matchAll(/<figcaption>([^<]+)/g)].map(([, title]) => title);
  const measures = { "modality_gap/f_hat": 0.3, "margin/f_hat": 0.1 }; // of a set of one domain
  assert.equal(titles([{ ...EPOCHS[0], measures: {} }]).length, 6);
  assert.deepEqual(titles([{ ...EPOCHS[0], measures }]), ["Loss", "Gaps of F̂", "Cosine margin of F̂", "p"]);
});
