/** What p does to both gaps of a head, computed from its curves. No DOM here. */

import { orderText } from "./frames.js";
import { GAPS, values } from "./measures.js";
import { ends, mean } from "./numbers.js";
import { INPUT, OUTPUT, stepsOf } from "./stages.js";
import { html } from "./text.js";

const STILL = 0.02; // a gap that ranges less is called constant

/** Return one gap over p: its value in the embedding, the lowest and highest of the output with their orders, and the
 * step at which the mean over p falls most. `by` is what closes most of it: "steps" if its fall from the embedding to
 * the highest is at least that from the highest to the lowest, "p" if not, "" if no p brings it below the embedding.
 * @param {Frames} frames @param {Measure} measure */
function gapOver(frames, { id, title }) {
  const all = (/** @type {string} */ stage) => (values(frames, id, stage) ?? []).filter(Number.isFinite);
  const output = values(frames, id, OUTPUT) ?? [];
  const [low, high] = ends(all(OUTPUT));
  const [raw] = all(INPUT);
  const steps = stepsOf(frames).filter((step) => all(step.id).length);
  const falls = steps.slice(1).map((step, i) => mean(all(steps[i].id)) - mean(all(step.id)));
  const [lowAt, highAt] = [low, high].map((v) => frames.orders[output.indexOf(v)]);
  const by = raw - high >= high - low ? "steps" : low < raw ? "p" : "";
  return {
    id,
    title: title.toLowerCase(),
    raw,
    low,
    high,
    lowAt,
    highAt,
    by,
    step: steps[1 + falls.indexOf(Math.max(...falls))],
  };
}
/** @typedef {ReturnType<typeof gapOver>} GapOver */

const two = (/** @type {number} */ v) => v.toFixed(2);
const at = (/** @type {number} */ p) => `at p = ${orderText(p)}`;

/** Return the part of a sentence that states one gap's range over p or over the steps.
 * @param {GapOver} gap @param {number} i its place in the sentence */
function rangeOf({ title, raw, low, high, lowAt, highAt, by }, i) {
  const before = `(${two(raw)}${i ? "" : " in the embedding"})`;
  if (high - low < STILL) return html`the ${title} stays at <b>${two(low)}</b> ${before}`;
  if (by === "steps") return html`the ${title} stays between <b>${two(low)}</b> and <b>${two(high)}</b> ${before}`;
  return html`the ${title} lies between <b>${two(low)}</b> ${at(lowAt)} and <b>
    ${two(high)}</b> ${at(highAt)} ${before}`;
}

/** Return whether p, or else the steps of the head, close its gaps: a short answer, and a sentence with the figures.
 * @param {Frames} frames the frames of all stops */
export function verdictOn(frames) {
  const gaps = GAPS.map((row) => gapOver(frames, row)).filter(({ raw, low }) => Number.isFinite(raw + low));
  if (!gaps.length) return null;
  const [closed, by] = ["p", "steps"].map((what) => gaps.filter((gap) => gap.by === what));
  const answer =
    closed.length === gaps.length
      ? "Yes, for this head."
      : closed.length
        ? `Only the ${closed[0].title}.`
        : by.length
          ? "No: the steps of the head close them."
          : "No, and neither do the steps.";
  const ranges = gaps.map((gap, i) => [i > 0 && ", and ", rangeOf(gap, i)]);
  const places = [...new Set(by.map(({ step }) => step.step))].join(" and the ");
  return {
    answer,
    closed: closed.length > 0,
    words: html`Over all p, ${ranges}.${places && ` Most of the fall is at the ${places}.`}`,
  };
}
