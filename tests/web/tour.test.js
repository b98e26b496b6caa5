import assert from "node:assert/strict";
import test from "node:test";
import { frames } from "./browser.js";

const { answer, onScreen, STEPS } = await import("../../app/web/header/steps.js");

const share = (share, low = share - 0.02, high = share + 0.02) => ({ share, low, high });
const unseen = {
  domains: [{ is_source: true, "answers/fused": share(0.8) }, { "answers/fused": share(0.6) }],
  unseen: { "answers/fused": share(0.6) },
  look_alikes: { pairs: 30, "answers/vis": share(0.2), "answers/tac": share(0.5) },
};
const figures = (more = {}, curve = [0.3, 0.9, 0.4]) =>
  onScreen(frames({ orders: [0, 0.35, 1], curves: { "accuracy/unseen": curve } }), {
    unseen,
    gaps: [0.6, 0.05],
    pale: [0.55, 0.56],
    ...more,
  });

test("each step has a question, its options and one that is right, over three chapters and both sets", () => {
  assert.deepEqual([...new Set(STEPS.map(({ chapter }) => chapter))], ["order", "failure", "fooled"]);
  for (const step of STEPS) {
    const at = figures(ladder(0.6, 0.64));
    const right = step.right(at);
    assert.equal(right.length, 1, step.title);
    assert.ok(step.options.some(([key]) => key === right[0]));
    assert.doesNotMatch(step.reveal(at), /NaN|undefined|–/, step.title);
  }
});

test("what is told follows the figures on the screen", () => {
  const [order, sensors, next, centre, touch] = STEPS;
  assert.deepEqual(order.right(figures()), ["mid"]);
  assert.deepEqual(order.after(figures()), { p: 0.35 });
  assert.deepEqual(order.right(figures({}, [0.6, 0.61, 0.6])), ["all"]);
  assert.deepEqual(sensors.right(figures({ pale: [0.3, 0.8] })), ["much"]);
  assert.deepEqual(next.right(figures()), ["part"]);
  assert.match(next.reveal(figures()), /80.*60/);
  assert.deepEqual(centre.right(figures({ gaps: [0.6, 0.5] })), ["same"]);
  assert.deepEqual(touch.right(figures()), ["tac"]);
});

test("there is no verdict where intervals overlap or figures are missing", () => {
  const alike = { pairs: 30, "answers/vis": share(0.4, 0.2, 0.6), "answers/tac": share(0.5, 0.3, 0.7) };
  const doubt = figures({ unseen: { ...unseen, look_alikes: alike } });
  assert.deepEqual(STEPS[4].right(doubt), []);
  assert.match(STEPS[4].reveal(doubt), /overlap/);
  const blind = figures({ unseen: { domains: [], unseen: {} }, gaps: null, pale: null }, null);
  for (const step of STEPS) {
    assert.deepEqual(step.right(blind), [], step.title);
    assert.doesNotMatch(step.reveal(blind), /NaN|undefined|Infinity/, step.title);
  }
});

const ladder = (low, high) => ({
  rungs: [{ rung: "n20", from: "this head", accuracy: 0.62, low, high }],
  records: [0.05, -0.01, 0.08],
});
const sentences = (text) => text.split(/\.(?= |$)/).filter(Boolean);

test("the tour ends with the title's answer in two or three sentences of the page's own figures", () => {
  const plain = (at) => answer(at).replace(/<[^>]*>/g, "");
  assert.equal(sentences(plain(figures())).length, 2);
  const text = plain(figures(ladder(0.6, 0.64)));
  assert.equal(sentences(text).length, 3);
  for (const figure of ["60", "80", "0.05", "0.60", "55", "56", "30", "90", "62", "64", "+4.0", "−1.0", "+8.0"])
    assert.ok(text.includes(figure), figure);
});

test("what pictures of a new sensor bring is called sure only if the intervals are apart", () => {
  const last = STEPS.at(-1);
  assert.deepEqual(last.right(figures(ladder(0.6, 0.64))), ["no"]);
  assert.match(last.reveal(figures(ladder(0.6, 0.64))), /not sure/);
  assert.deepEqual(last.right(figures(ladder(0.63, 0.66))), ["yes"]);
  assert.doesNotMatch(last.reveal(figures(ladder(0.63, 0.66))), /not sure/);
  assert.deepEqual(last.right(figures()), []);
});
