/** The line from dropped pictures to saved results: where the visitor is, and what one more step brings. */

import { TABLES } from "../shared/tables.js";
import { each, escaped, percent } from "../shared/text.js";
import { gainOf } from "./reader.js";
import { missing } from "./tally.js";

const STEPS = ["Drop", "See", "Label", "Teach", "Use", "Save"];

/** The step in hand, as an index of STEPS. dropped: pictures of the visitor's are there; pairs: labelled ones;
 * report: of teaching; used: the taught head predicts. */
export function stepOf({ dropped, pairs, report, used }) {
  if (used) return 5;
  if (report) return 4;
  if (pairs.length && !missing(pairs)) return 3;
  if (pairs.length || dropped) return 2;
  return 0;
}

/** What the next step is and what it brings, in a sentence. reader: facts of the head for own pictures, if it reads;
 * rungs: of the ladder, measured on simulated sensors. */
export function nextStep(at, { pairs, report, counts, reader = null }, rungs) {
  const of = (id) => rungs.find(({ rung }) => rung === id)?.accuracy;
  const gains = TABLES.rungs
    .filter(({ step, id }) => step === at && Number.isFinite(of(id) - of("none")))
    .map(({ id, title }) => `${title} bring ${(100 * (of(id) - of("none"))).toFixed(1)} points`);
  const points = gains.length ? ` On simulated sensors ${gains.join(", ")}.` : "";
  if (at === 0)
    return "Drop photos, touches, a folder or a CSV anywhere here. As they come, expect guesses: the head has not seen your sensor.";
  if (at === 2 && !pairs.length && !counts)
    return `Label two pairs of each of two classes. Or make a profile of pictures without labels.${reader ? ` ${gainOf(reader)}` : points}`;
  if (at === 2) return missing(pairs) || "Label two pairs of each of two classes, and teach the head.";
  if (at === 3) return `Teach it your ${pairs.length} pairs.${points}`;
  const { right, judged } = report;
  return `${percent(right.after / judged.length)} of your pairs are right with each left out, ${percent(right.before / judged.length)} before. Drop the next pictures: the taught head reads them. Save it and unpack it for the command line: omnivat predict --head taught-head --pairs FOLDER${counts ? " --profile my-sensor.safetensors" : ""}.`;
}

export const lineHtml = (at, words) =>
  `<ol>${each(STEPS, (name, i) => `<li${i === at ? ' aria-current="step"' : ""}>${i < at ? "✓ " : ""}${name}</li>`)}</ol><p>${escaped(words)}</p>`;
