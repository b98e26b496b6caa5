import assert from "node:assert/strict";
import test from "node:test";
import "./browser.js";
import { asText, axis, spread, values } from "../../app/web/shared/measures.js";
import { frames } from "./browser.js";

test("accuracy of a head, in any mode, is of domains that it never saw, and its source holds training pairs", () => {
  const curves = { "accuracy/all": [0.9], "accuracy/unseen": [0.6], "accuracy/A": [1], "accuracy/B": [0.6] };
  for (const kind of ["moved", "retrained"]) {
    const found = ["", "B", "A"].map((domain) =>
      values(frames({ curves, head: { kind } }), "accuracy", "f_hat", domain),
    );
    assert.deepEqual(found, [[0.6], [0.6], null], kind);
  }
});

test("of retrained heads it is the mean over trainings, with its span", () => {
  const curves = {
    "seeds:accuracy/unseen/mean": [0.6],
    "seeds:accuracy/unseen/low": [0.5],
    "seeds:accuracy/unseen/high": [0.7],
    "seeds:accuracy/source_test/mean": [0.8],
  };
  const found = frames({ curves, head: { kind: "retrained" } });
  assert.deepEqual(values(found, "accuracy", "f_hat"), [0.6]);
  assert.deepEqual(values(found, "accuracy", "f_hat", "A"), [0.8]);
  assert.deepEqual(spread(found, "accuracy", "f_hat"), { low: [0.5], high: [0.7] });
  assert.equal(spread(found, "margin", "f_hat"), null);
});

test("the projection has the gaps of the transform, which keeps all distances", () => {
  const found = frames({ curves: { "modality_gap/frft": [1.1] } });
  assert.deepEqual(values(found, "modality_gap", "projection"), [1.1]);
});

test("an axis holds every stage, so that a flat line stays flat", () => {
  const found = frames({ curves: { "margin/raw": [0.4, 0.4], "margin/f_hat": [-0.1, 1.24] } });
  const [low, high] = axis(found, "margin");
  assert.ok(low <= -0.1 && high >= 1.24);
  assert.deepEqual(axis(found, "accuracy"), [0, 1]);
});

test("a value that is missing is a dash", () => {
  assert.equal(asText("margin", undefined), "–");
  assert.equal(asText("accuracy", 0.616), "61.6\u00a0%");
});
