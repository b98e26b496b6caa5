/** The words and figures of the chapters, made from what is on the screen. */

import { remedyHtml } from "../shared/headless.js";
import { ACCURACY, values } from "../shared/measures.js";
import { ends } from "../shared/numbers.js";
import { ofFrames, strangers, unseenPairs } from "../shared/provenance.js";
import { INPUT, OUTPUT } from "../shared/stages.js";
import { modeOf, sensorOf, TABLES } from "../shared/tables.js";
import { html, percent } from "./root.js";
import { whole } from "./scene.js";

const CLEAR = 0.1; // of accuracy: a smaller change over p is called small
const AWAY = 0.8; // the order at which the first chapter opens if p decides: most heads fail there
const NUMBERS = "no one two three four five six seven eight nine ten eleven twelve".split(" ");
const inWords = (/** @type {number} */ n) => NUMBERS[n] ?? String(n);
const unseenDomains = (/** @type {Frames} */ frames) => {
  const n = strangers(frames);
  return `${inWords(n)} unseen domain${n === 1 ? "" : "s"}`;
};

/** {best, low, high, range}: the order of the highest accuracy, and how far accuracy ranges over p; null if unknown.
 * @param {Frames} frames */
function decided(frames) {
  const curve = values(frames, ACCURACY, OUTPUT) ?? [];
  const [low, high] = ends(curve);
  if (high < low) return null; // none is known
  return { best: frames.orders[curve.indexOf(high)], low, high, range: high - low };
}

/** Return the order at which a chapter opens. @param {string} chapter @param {Frames} frames @param {Frames} own */
export function startOf(chapter, frames, own) {
  const clear = chapter === "order" && (decided(frames)?.range ?? 0) >= CLEAR;
  return frames.orders[frames.stop(clear ? AWAY : Number.isFinite(own.learned) ? own.learned : 0.5)];
}

/** Return the accuracy at one stop; NaN if it is not known. @param {Frames} frames @param {number} stop */
export const rightAt = (frames, stop) => values(frames, ACCURACY, OUTPUT)?.[stop] ?? NaN;

/** Return the same in one sentence on a screen. @param {Frames} frames @param {number} stop */
export function headOf(frames, stop) {
  const right = rightAt(frames, stop);
  return Number.isFinite(right)
    ? html`<b class="large">${percent(right)}</b> <span>correct in ${unseenDomains(frames)}</span>`
    : html`<small>There is no accuracy for unseen domains: ${blind(frames)}</small>`;
}

/** Return why there is no unseen accuracy. @param {Frames} frames */
function blind(frames) {
  const { source, domains, labelled } = frames;
  if (labelled === false) return "the pairs have no classes.";
  if (!source) return "the file of the head does not name its training domain.";
  if (!domains.includes(source)) return `the head was trained on ${sensorOf(source)}, which is not in this set.`;
  return strangers(frames) ? "it was not measured." : "the set has no domain besides the training domain.";
}

/** Return where the accuracy at one stop comes from; null if it is not known.
 * @param {Frames} frames @param {number} stop @param {Unseen | null} [unseen] */
export const whence = (frames, stop, unseen) =>
  Number.isFinite(rightAt(frames, stop)) ? ofFrames(frames, stop, unseenPairs(frames, unseen)) : null;

/** Return the same for the loaded head at its own p, over some pairs.
 * @type {(own: Frames, pairs: string) => Html} */
export const ofOwn = (own, pairs) => ofFrames(own, own.stop(own.learned), pairs);

/** Return the three measures of features without a head, and what a head would need. @param {Scene} scene */
export function featuresHtml({ own, facts: { fit } }) {
  const gaps = TABLES.measures.map(({ id, title, help }) => {
    const value = values(own, id, INPUT)?.[0] ?? NaN;
    return Number.isFinite(value) && html`<dt title="${help}">${title}</dt><dd>${value.toFixed(2)}</dd>`;
  });
  return html`<span class="measured"><b>Features of the encoder, without a head.</b></span>
    <dl class="gaps">${gaps}</dl>${headlessHtml(fit)}`;
}

const headlessHtml = (/** @type {Fit | null} */ fit) =>
  fit?.problem
    ? html`<details><summary>Why no head?</summary><p>${fit.problem}</p></details>${remedyHtml(fit)}`
    : html``;

/** Return the words of the chapter of the order. @type {(scene: Scene) => Words} */
function order(scene) {
  const { frames, stop, facts } = scene;
  const accuracy = decided(frames);
  const figure = headOf(frames, stop);
  const from = whence(frames, stop, facts.unseen) ?? html``;
  if (!accuracy) return { title: "When does the order p matter?", figure, remark: html`Drag p to change the map.` };
  const { best, low, high, range } = accuracy;
  if (range < CLEAR)
    return {
      title: "On this set, the order p hardly changes accuracy.",
      figure,
      whence: from,
      remark: html`Drag p. At every p, accuracy lies between ${percent(low)} and ${percent(high)}.`,
    };
  const kinds = `${inWords(frames.classes.length)} kinds of ${frames.signals ? "signal" : "pair"}`;
  return {
    title:
      Math.abs(frames.orders[stop] - best) < 0.026
        ? `At one value of p, ${kinds} separate.`
        : `At which value of p do ${kinds} separate?`,
    figure,
    whence: from,
    remark: whole(scene)
      ? html`At the worst p, accuracy falls to ${percent(low)}. Grey line: on touch sensors, accuracy is about the same
        at every p.`
      : html`Drag <i>p</i> from 0 to 1. ${modeOf(frames).note}`,
  };
}

/** Return the words of the chapter of look-alikes. @type {(scene: Scene) => Words} */
function fooled({ own, facts: { unseen, fit } }) {
  const words = { title: "When is touch needed?", figure: html``, remark: html`` };
  if (own.headless) return { ...words, title: "This chapter needs a head.", remark: headlessHtml(fit) };
  if (!unseen) return words;
  const alike = unseen.look_alikes;
  const pairs = unseen.domains.reduce((sum, domain) => sum + (domain.is_source ? 0 : domain.pairs), 0);
  if (!alike)
    return {
      title: "In which domains does the head fail?",
      figure: unseen.unseen["answers/fused"] ? html`` : html`There is no accuracy for unseen domains: ${blind(own)}`,
      remark: unseen.domains.some((domain) => domain["answers/fused"])
        ? html`Short bar: 95 % interval. Thin line: chance.${ofOwn(own, unseenPairs(own, unseen))}`
        : html``,
    };
  const [photo, touch] = [alike["answers/vis"], alike["answers/tac"]];
  const [lower, higher] = photo.share < touch.share ? [photo, touch] : [touch, photo];
  const share = (/** @type {Reading} */ reading) => percent(unseen.unseen[`answers/${reading}`]?.share);
  return {
    ...words,
    figure: html`In <b>${percent(alike.pairs / pairs)}</b> of the unseen pairs, the photo looks like another class.`,
    remark: html`${
      lower.high < higher.low
        ? `For these pairs, the ${higher === touch ? "touch" : "photo"} alone is correct more often.`
        : "For these pairs, the intervals of photo and touch overlap: neither is clearly better."
    } For all unseen pairs, the photo alone is correct in ${share("vis")}, the touch in ${share("tac")}, both together
      in ${share("fused")}.${ofOwn(own, `the ${alike.pairs} look-alikes`)}`,
  };
}

/** What follows a chapter, and its words; the workbench has none, and the second and third have their own.
 * @type {Record<string, {to: string, next: string, words?: (scene: Scene) => Words}>} */
export const LESSONS = {
  gaps: { to: "where", next: "Next →" },
  where: { to: "order", next: "Next →" },
  order: { words: order, to: "fooled", next: "Next →" },
  fooled: { words: fooled, to: "analyse", next: "Analyse →" },
};
