/** What the page says fits the set: photos and touches, or recordings of signals. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { frames } from "./browser.js";

const { card } = await import("../../app/web/shared/card.js");
const { explained, stageNamed, STAGES } = await import("../../app/web/shared/stages.js");
const { modeWords } = await import("../../app/web/explore/modes.js");
const { onScreen, STEPS } = await import("../../app/web/header/steps.js");
const { ABOUT } = await import("../../app/web/data/words.js");
const { apart } = await import("../../app/web/explore/balance.js");

const SIGNALS = frames({
  signals: true,
  curves: { "modality_gap/raw": [0.04, 0.04, 0.04], "domain_gap/raw": [0.1, 0.1, 0.1] },
});

test("a set of signals has neither photos nor sensors", () => {
  assert.match(card(SIGNALS, null, -1, 0, false), /Two recordings of one signal/);
  assert.match(card(frames(), null, -1, 0, false), /A photo and a touch/);
  assert.match(modeWords(SIGNALS), /two recordings of one signal/);
  assert.doesNotMatch(modeWords(frames()), /signal/);
  const at = onScreen(SIGNALS, 0, { unseen: { source: "A" } });
  for (const step of STEPS.slice(0, 2)) {
    assert.doesNotMatch(step.ask(at), /is a photo|sensor/);
    assert.doesNotMatch(step.reveal(at), /photos|sensors/);
  }
});

test("no step of the head is said to move gaps in a way that only some sets show", () => {
  for (const stage of STAGES) assert.doesNotMatch(stage.explain, /are apart|together\. The classes/);
});

test("flat gaps of the transform are claimed only where all stops are one head", () => {
  const transform = stageNamed("frft");
  assert.match(explained(transform, frames()), /No point moves/);
  assert.doesNotMatch(explained(transform, frames({ head: { kind: "retrained" } })), /No point moves|flat/);
  assert.equal(STEPS[2].set.mode, "moved"); // the tour tells of flat gaps where they are flat
});

test("the limits that are told belong to the set", () => {
  assert.match(ABOUT(true, true), /near one p only/);
  assert.doesNotMatch(ABOUT(true, true), /any p do about equally/);
  assert.match(ABOUT(true, false), /simulated sensors heads trained at any p do about equally well/);
});

test("names of steps that stand close move apart and stay around their places", () => {
  const found = apart([20, 21, 80, 22], 15);
  assert.ok(found[1] - found[0] >= 15 && found[3] - found[1] >= 15);
  assert.equal(found[2], 80);
  assert.ok(Math.abs((found[0] + found[1] + found[3]) / 3 - 21) < 1e-9);
});
