import assert from "node:assert/strict";
import test from "node:test";
import "./browser.js";
import { answer, STEPS } from "../../app/web/header/steps.js";

const share = (share, low = share - 0.02, high = share + 0.02) => ({ share, low, high });
const shares = (v) => [v, v - 0.03, v + 0.03];
const unseen = {
  domains: [{ is_source: true, "answers/fused": share(0.8) }, { "answers/fused": share(0.6) }],
  unseen: { "answers/fused": share(0.6) },
  look_alikes: { pairs: 30, "answers/vis": share(0.2), "answers/tac": share(0.5) },
};
const twins = (printed = 0.29, filled = 0.66, few = 0.51) => ({
  pictures: [5, 200],
  away: {
    touch: [
      [
        [shares(printed), shares(0.37), shares(few)],
        [shares(filled), shares(0.67), shares(0.7)],
      ],
    ],
  },
  accuracy: { touch: [[[[shares(0.72)]]]] },
});
const figures = (more = {}, curve = [0.3, 0.9, 0.4]) => ({
  orders: [0, 0.35, 1],
  curve,
  unseen,
  twins: twins(),
  places: { accuracy: [0.29, 0.31, 0.52] },
  pale: [0.55, 0.56],
  ...more,
});
const rightOf = ({ right, options }, at = figures()) => right(at).map((i) => options[i]);
const named = (title) => STEPS.find((step) => step.title === title);

test("each question has its options and one that is right, over four chapters, and the last step tells", () => {
  assert.deepEqual([...new Set(STEPS.map(({ chapter }) => chapter))], ["touch", "where", "order", "fooled"]);
  for (const step of STEPS) assert.doesNotMatch(String(step.reveal(figures())), /NaN|undefined|–/, step.title);
  for (const step of STEPS.filter(({ ask }) => ask)) {
    const right = rightOf(step);
    assert.ok(right.length === 1 && right[0], step.title);
  }
  assert.equal(STEPS.at(-1).ask, undefined);
});

test("what is right follows the figures on the screen", () => {
  const right = (title, at) => rightOf(named(title), at);
  assert.deepEqual(right("One touch"), ["Less than half"]);
  assert.deepEqual(right("One touch", figures({ twins: twins(0.7) })), ["Nearly all"]);
  assert.deepEqual(right("The dots"), ["More than half"]);
  assert.deepEqual(right("The dots", figures({ twins: twins(0.29, 0.3) })), ["Hardly any"]);
  assert.deepEqual(right("Where they go"), ["Not yet"]);
  assert.deepEqual(right("Where they go", figures({ places: { accuracy: [0.3, 0.5, 0.52] } })), ["Mostly"]);
  assert.deepEqual(right("The order p on touch", figures({ pale: [0.3, 0.8] })), ["Over ten points"]);
  assert.deepEqual(right("When does p decide?"), ["Near 0.35"]);
  assert.deepEqual(named("When does p decide?").after(figures()), { p: 0.35 });
  assert.deepEqual(right("When does p decide?", figures({}, [0.6, 0.61, 0.6])), ["Everywhere alike"]);
  assert.deepEqual(right("When is touch needed?"), ["The touch"]);
});

test("there is no verdict where intervals overlap or figures are missing", () => {
  const alike = { pairs: 30, "answers/vis": share(0.4, 0.2, 0.6), "answers/tac": share(0.5, 0.3, 0.7) };
  const doubt = figures({ unseen: { ...unseen, look_alikes: alike }, twins: twins(0.29, 0.52, 0.51) });
  assert.deepEqual(named("When is touch needed?").right(doubt), []);
  assert.match(String(named("When is touch needed?").reveal(doubt)), /overlap/);
  assert.deepEqual(rightOf(named("Without one label"), doubt), ["About as much"]);
  const blind = figures({ unseen: { domains: [], unseen: {} }, twins: null, places: null, pale: null }, null);
  for (const step of STEPS.filter(({ needs }) => !needs)) {
    assert.deepEqual(step.right(blind), [], step.title);
    assert.doesNotMatch(String(step.reveal(blind)), /NaN|undefined|Infinity/, step.title);
  }
});

test("the tour ends with the title's answer in sentences of the page's own figures", () => {
  const text = String(answer(figures())).replace(/<[^>]*>/g, "");
  for (const figure of ["29", "72", "66", "70", "55", "56", "30", "90"]) assert.ok(text.includes(figure), figure);
  assert.match(text, /Most of that/);
  assert.doesNotMatch(String(answer(figures({ twins: twins(0.29, 0.4) }))), /Most of that/);
});
