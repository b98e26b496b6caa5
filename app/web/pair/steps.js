/** The line from dropped pictures to saved results: where the visitor is, and what one more step brings. */

import { PLACES, TABLES } from "../shared/tables.js";
import { html, percent } from "./parts.js";
import { gainOf } from "./reader.js";
import { isOwn, missing } from "./state.js";

const STEPS = ["Drop", "See", "Label", "Teach", "Use", "Save"];

/** The step in hand, as an index of STEPS. @param {PairTab} tab */
function stepOf({ rows, pairs, report, taught, vis, tac }) {
  if (taught) return 5;
  if (report) return 4;
  if (pairs.length && !missing(pairs)) return 3;
  return pairs.length || rows.length || isOwn({ vis, tac }) ? 2 : 0;
}

/** What the rungs of a step bring beside nothing, in words. The ladder is that of the head of the chapters; what
 * another head reads, or was measured with, is no gain of it. @param {number} at @param {PairTab} tab */
function gains(at, { head, rungs, simulated }) {
  const nothing = rungs.find(({ rung }) => rung === PLACES[0].id);
  const own = new Set(TABLES.rungs.flatMap(({ step, id }) => (step === at ? id : [])));
  const climbed = rungs.filter(({ rung, from }) => own.has(rung) && from === nothing?.from);
  if (head || !nothing || !climbed.length) return "";
  const words = climbed.map(
    ({ known, accuracy }) => `${known} raise accuracy by ${(100 * (accuracy - nothing.accuracy)).toFixed(1)} points`,
  );
  return ` On ${simulated ? "simulated" : "the unseen"} sensors ${words.join(" and ")} (${nothing.from}).`;
}

/** What the next step is and what it brings, in a sentence. @param {number} at @param {PairTab} tab */
function nextStep(at, tab) {
  const { pairs, report, counts, head, facts } = tab;
  const points = gains(at, tab);
  if (at === 0)
    return html`Drop photos, touches, a folder or a CSV file anywhere on this page. Expect guesses at first, because the
      head has not seen your sensor.`;
  if (at === 2 && !pairs.length && !counts)
    return html`Label two pairs of each of two classes, or make a profile of unlabelled
      pictures.${head ? ` ${gainOf(facts)}` : points}`;
  if (at === 2) return missing(pairs);
  if (at === 3) return `Teach the head your ${pairs.length} pairs.${points}`;
  const { judged, right } = /** @type {Taught} */ (report);
  const profile = counts ? " --profile my-sensor.safetensors" : "";
  const [before, after] = [right.before, right.after].map((count) => percent(count / judged.length));
  return html`Teaching raised the share of correct pairs from ${before} to ${after}, each pair predicted without its own
    label. Drop the next pictures for the taught head, or save it for the command line: omnivat predict --head
    taught-head --pairs FOLDER${profile}.`;
}

/** @param {PairTab} tab */
export function lineHtml(tab) {
  const at = stepOf(tab);
  const steps = STEPS.map(
    (name, i) => html`<li${i === at && html` aria-current="step"`}>${i < at && "✓ "}${name}</li>`,
  );
  return html`<ol>${steps}</ol><p>${nextStep(at, tab)}</p>`;
}
