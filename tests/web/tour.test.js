import assert from "node:assert/strict";
import test from "node:test";
import "./browser.js";
import { STEPS } from "../../app/web/header/steps.js";

const share = (share, low = share - 0.02, high = share + 0.02) => ({ share, low, high });
const shares = (v) => [v, v - 0.03, v + 0.03];
const unseen = { look_alikes: { pairs: 30, "answers/vis": share(0.2), "answers/tac": share(0.5) } };
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
const figures = (more = {}) => ({
  orders: [0, 0.35, 1],
  curve: [0.3, 0.9, 0.4],
  unseen,
  twins: twins(),
  gaps: { closed: false, words: "Over all p" },
  places: { accuracy: [0.29, 0.31, 0.52] },
  pale: [0.55, 0.56],
  ...more,
});
const rightOf = ({ right, options }, at = figures()) => right(at).map((i) => options[i]);
const named = (title) => STEPS.find((step) => step.title === title);

test("each question has its options and one that is right, over five chapters, and the last step tells", () => {
  assert.deepEqual([...new Set(STEPS.map(({ chapter }) => chapter))], ["touch", "gaps", "where", "order", "fooled"]);
  for (const step of STEPS) assert.doesNotMatch(String(step.reveal(figures())), /NaN|undefined|–/, step.title);
  for (const step of STEPS.filter(({ ask }) => ask)) {
    const right = rightOf(step);
    assert.ok(right.length === 1 && right[0], step.title);
  }
  assert.equal(STEPS.at(-1).ask, undefined);
});

test("what is right follows the figures on the screen", () => {
  for (const [title, wanted, more] of [
    ["One touch", "Nearly all", { twins: twins(0.7) }],
    ["The dots", "Hardly any", { twins: twins(0.29, 0.3) }],
    ["Without one label", "About as much", { twins: twins(0.29, 0.52) }],
    ["Where they go", "Mostly", { places: { accuracy: [0.3, 0.5, 0.52] } }],
    ["p and the gaps", "Yes, one of them or both", { gaps: { closed: true } }],
    ["When does p matter?", "Near 0.35"],
    ["When does p matter?", "Equally at every p", { curve: [0.6, 0.61, 0.6] }],
    ["When is touch needed?", "The touch"],
  ])
    assert.deepEqual(rightOf(named(title), figures(more)), [wanted]);
  assert.deepEqual(named("When does p matter?").after(figures()), { p: 0.35 });
});

test("there is no verdict where intervals overlap or figures are missing", () => {
  const alike = { pairs: 30, "answers/vis": share(0.4, 0.2, 0.6), "answers/tac": share(0.5, 0.3, 0.7) };
  const doubt = figures({ unseen: { look_alikes: alike } });
  assert.deepEqual(named("When is touch needed?").right(doubt), []);
  assert.match(String(named("When is touch needed?").reveal(doubt)), /overlap/);
  const blind = figures({ unseen: {}, twins: null, places: null, gaps: null, pale: null, curve: null });
  for (const step of STEPS.filter(({ needs }) => !needs)) {
    assert.deepEqual(step.right(blind), [], step.title);
    assert.doesNotMatch(String(step.reveal(blind)), /NaN|undefined|Infinity/, step.title);
  }
});
