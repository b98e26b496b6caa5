/** What the page says fits the set: photos and touches, or recordings of signals. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { modeWords } from "../../app/web/explore/modes.js";
import { speakOfSignals } from "../../app/web/pair/parts.js";
import { cards } from "../../app/web/pair/verdict.js";
import { card } from "../../app/web/shared/card.js";
import { explained, isStill, stageNamed } from "../../app/web/shared/stages.js";
import { frames, says } from "./browser.js";

const SIGNALS = frames({
  signals: true,
  curves: { "modality_gap/raw": [0.04, 0.04, 0.04], "domain_gap/raw": [0.1, 0.1, 0.1] },
});

test("a set of signals has neither photos nor sensors", () => {
  says(card(SIGNALS, null, -1, 0, false), /Two recordings of one signal/);
  says(card(frames(), null, -1, 0, false), /A photo and a touch/);
  says(modeWords(SIGNALS), /two recordings of one signal/);
  assert.doesNotMatch(`${modeWords(frames())}`, /signal/);
});

test("flat gaps of the transform are claimed only where the frames have one map of it, in whatever mode", () => {
  const transform = stageNamed("frft");
  for (const kind of ["moved", "retrained", "another"]) {
    const shown = frames({ head: { kind } });
    assert.match(explained(transform, shown), /No point moves/);
    shown.meta.maps["pca/frft"] = { array: 2, orders: [0, 1, 2] };
    assert.doesNotMatch(explained(transform, shown), /No point moves|flat|undefined/);
    assert.equal(explained(transform, shown).includes("another head"), kind === "retrained");
    assert.ok(!isStill("projection", shown) && isStill("raw", shown));
  }
});

test("a pair of signals is called two recordings", () => {
  speakOfSignals();
  const html = String(
    cards({ classes: ["a", "b"], exact: { readings: { fused: [1, 0], vis: [1, 0] } }, images: {} }, {}),
  );
  assert.match(html, /First only/);
  assert.match(html, /This pair has no second recording/);
  assert.doesNotMatch(html, /[Pp]hoto|[Tt]ouch/);
});
