import assert from "node:assert/strict";
import test from "node:test";
import { frames } from "./browser.js";

const { onScreen, STEPS } = await import("../../app/web/header/steps.js");

const share = (share, low = share - 0.02, high = share + 0.02) => ({ share, low, high });
const facts = {
  unseen: {
    source: "A",
    chance: 0.5,
    unseen: { "answers/fused": share(0.6), "answers/vis": share(0.7), "answers/tac": share(0.3) },
  },
  toy: { distances: { signals: { turned: [1.46], clipped: [0.7, 1.1] } } },
};
const curves = {
  "modality_gap/raw": [0.6, 0.6, 0.6],
  "domain_gap/raw": [0.5, 0.5, 0.5],
  "margin/raw": [0.1, 0.1, 0.1],
  "modality_gap/relu": [0.8, 0.8, 0.8],
  "modality_gap/f_bar": [0.1, 0.1, 0.1],
  "modality_gap/f_hat": [0.3, 0.3, 0.3],
  "margin/frft": [0.1, 0.1, 0.1],
  "margin/f_bar": [0.02, 0.02, 0.02],
  "margin/f_hat": [0.5, 0.5, 0.5],
  "accuracy/unseen": [0.2, 0.7, 0.3],
};
const screen = (more = {}) =>
  onScreen(frames({ curves: { ...curves, ...more.curves }, head: more.head }), 0.5, {
    ...facts,
    ...more.facts,
  });

test("there are six steps, each with a question, its options and one that is right", () => {
  assert.equal(STEPS.length, 6);
  for (const step of STEPS) {
    const keys = step.options.map(([key]) => key);
    for (const right of [step.right(screen())].flat()) assert.ok(keys.includes(right), step.title);
    assert.doesNotMatch(step.reveal(screen()), /NaN|undefined|–/, step.title);
  }
});

test("what is told follows the figures on the screen", () => {
  const [gap, domain, , small, p, strangers] = STEPS;
  assert.equal(gap.right(screen({ curves: { "modality_gap/raw": [0, 0.1, 0] } })), "near");
  assert.equal(domain.right(screen({ curves: { "margin/raw": [0.9, 0.9, 0.9] } })), "class");
  assert.deepEqual(small.right(screen()), ["f_bar"]);
  assert.match(small.reveal(screen()), /0\.10.*0\.02.*0\.50.*moved together/);
  assert.deepEqual(small.right(screen({ curves: { "modality_gap/f_hat": [0, 0.01, 0] } })), ["f_hat"]);
  assert.equal(p.right(screen()), "much");
  assert.match(
    p.reveal(screen()),
    /20.*p = 0\.00.*70.*p = 0\.50.*does not show how well a head trained at another p does/,
  );
  assert.equal(strangers.right(screen()), "vis");
  assert.match(strangers.reveal(screen()), /photo only <b>70/);
  assert.doesNotMatch(strangers.reveal(screen()), /overlap/);
});

test("equal figures are equally right, and classes that were never apart have not moved together", () => {
  const chirps = screen({
    curves: {
      "modality_gap/relu": [0, 0.031, 0],
      "modality_gap/f_bar": [0, 0.033, 0],
      "margin/frft": [0, 0.001, 0],
      "margin/f_bar": [0, 0.09, 0],
    },
  });
  assert.deepEqual(STEPS[3].right(chirps), ["relu", "f_bar"]);
  assert.match(STEPS[3].reveal(chirps), /ReLU and F̄.*0\.03.*0\.09.*0\.50.*still close together/);
});

test("what a set cannot decide is said, without a verdict", () => {
  const [, domain, , , p] = STEPS;
  const alone = screen({ curves: { "domain_gap/raw": [null, null, null] } });
  assert.deepEqual(domain.right(alone), []);
  assert.match(domain.reveal(alone), /one domain/);
  const { "accuracy/unseen": _, ...rest } = curves;
  const blind = onScreen(frames({ curves: rest }), 0.5, facts);
  assert.deepEqual(p.right(blind), []);
  assert.match(p.reveal(blind), /no accuracy on unseen domains/);
});

test("where intervals overlap the tour says so", () => {
  const unseen = {
    ...facts.unseen,
    unseen: { ...facts.unseen.unseen, "answers/fused": share(0.69, 0.6, 0.78) },
  };
  assert.match(STEPS[5].reveal(screen({ facts: { unseen } })), /intervals of photo only and both overlap/);
});

test("of heads trained at each p it tells whether p matters on this set", () => {
  const retrained = (all) =>
    screen({ curves: { "seeds:accuracy/unseen/mean": all }, head: { kind: "retrained" } });
  assert.equal(STEPS[4].right(retrained([0.6, 0.63, 0.61])), "little");
  assert.match(STEPS[4].reveal(retrained([0.6, 0.63, 0.61])), /equally well/);
  assert.match(STEPS[4].reveal(retrained([0.3, 0.99, 0.4])), /the right p decides/);
});
