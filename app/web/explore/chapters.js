/** The words and figures of the chapters, made from what is on the screen. */

import { remedyHtml } from "../shared/headless.js";
import { ACCURACY, values } from "../shared/measures.js";
import { ofFrames, strangers, unseenPairs } from "../shared/provenance.js";
import { INPUT, OUTPUT } from "../shared/stages.js";
import { modeOf, TABLES } from "../shared/tables.js";
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
export function decided(frames) {
  const curve = values(frames, ACCURACY, OUTPUT) ?? [];
  const known = curve.filter(Number.isFinite);
  if (!known.length) return null;
  const [low, high] = [Math.min(...known), Math.max(...known)];
  return { best: frames.orders[curve.indexOf(high)], low, high, range: high - low };
}

/** The order at which a chapter opens. @param {string} chapter @param {Frames} frames @param {Frames} own */
export function startOf(chapter, frames, own) {
  const clear = chapter === "order" && (decided(frames)?.range ?? 0) >= CLEAR;
  return frames.orders[frames.stop(clear ? AWAY : Number.isFinite(own.learned) ? own.learned : 0.5)];
}

/** The accuracy at one stop; NaN if it is not known. @param {Frames} frames @param {number} stop */
export const rightAt = (frames, stop) => values(frames, ACCURACY, OUTPUT)?.[stop] ?? NaN;

/** The same in one sentence on a screen. @param {Frames} frames @param {number} stop */
export function headOf(frames, stop) {
  const right = rightAt(frames, stop);
  return Number.isFinite(right)
    ? html`<b class="large">${percent(right)}</b> <span>right in ${unseenDomains(frames)}</span>`
    : html`<small>Unseen accuracy is unknown here: ${blind(frames)}</small>`;
}

/** Why there is no unseen accuracy. @param {Frames} frames */
function blind(frames) {
  const { source, domains, labelled } = frames;
  if (labelled === false) return "the pairs have no classes.";
  if (!source) return "the source of the head is not stated.";
  if (!domains.includes(source)) return `the head was trained on ${source}, which is not in this set.`;
  return strangers(frames) ? "it was not measured." : "there is no domain that the head has not seen.";
}

/** Where the accuracy at one stop comes from; null if it is not known.
 * @param {Frames} frames @param {number} stop @param {Unseen | null} [unseen] */
export const whence = (frames, stop, unseen) =>
  Number.isFinite(rightAt(frames, stop)) ? ofFrames(frames, stop, unseenPairs(frames, unseen)) : null;

/** The same for the loaded head at its own p, over some pairs.
 * @type {(own: Frames, pairs: string) => Html} */
export const ofOwn = (own, pairs) => ofFrames(own, own.stop(own.learned), pairs);

/** The three measures of features without a head, and what a head would need. @param {Scene} scene */
export function featuresHtml({ own, facts: { fit } }) {
  const gaps = TABLES.measures.map(({ id, title, help }) => {
    const value = values(own, id, INPUT)?.[0] ?? NaN;
    return Number.isFinite(value) && html`<dt title="${help}">${title}</dt><dd>${value.toFixed(2)}</dd>`;
  });
  return html`<span class="measured"><b>The encoder’s features, no head.</b></span><dl class="gaps">${gaps}</dl>${headlessHtml(fit)}`;
}

const headlessHtml = (/** @type {Fit | null} */ fit) =>
  fit?.problem
    ? html`<details><summary>Why no head?</summary><p>${fit.problem}</p></details>${remedyHtml(fit)}`
    : html``;

/** @type {(scene: Scene) => Words} */
function order(scene) {
  const { frames, stop, facts } = scene;
  const accuracy = decided(frames);
  const figure = headOf(frames, stop);
  const from = whence(frames, stop, facts.unseen) ?? html``;
  if (!accuracy) return { title: "When does the order p decide?", figure, remark: html`Drag p: the map follows.` };
  const { best, low, high, range } = accuracy;
  if (range < CLEAR)
    return {
      title: "On this set the order p hardly matters.",
      figure,
      whence: from,
      remark: html`Drag p. Accuracy stays between ${percent(low)} and ${percent(high)}.`,
    };
  const kinds = `${inWords(frames.classes.length)} kinds of ${frames.signals ? "signal" : "pair"}`;
  return {
    title:
      Math.abs(frames.orders[stop] - best) < 0.026
        ? `At one order, ${kinds} come apart.`
        : `At which order do ${kinds} come apart?`,
    figure,
    whence: from,
    remark: whole(scene)
      ? html`Accuracy falls to ${percent(low)} at worst. Grey: on touch sensors every order does about as well.`
      : html`Drag <i>p</i> from end to end. ${modeOf(frames).note}`,
  };
}

/** @type {(scene: Scene) => Words} */
function fooled({ own, facts: { unseen, fit } }) {
  const words = { title: "When is touch needed?", figure: html``, remark: html`` };
  if (own.headless) return { ...words, title: "Who is fooled? That takes a head.", remark: headlessHtml(fit) };
  if (!unseen) return words;
  const alike = unseen.look_alikes;
  const pairs = unseen.domains.reduce((sum, domain) => sum + (domain.is_source ? 0 : domain.pairs), 0);
  if (!alike)
    return {
      title: "Which domains fool the head?",
      figure: unseen.unseen["answers/fused"] ? html`` : html`Learned from ${own.source}: ${blind(own)}`,
      remark: unseen.domains.some((domain) => domain["answers/fused"])
        ? html`Each bar has its 95 % interval. The thin line is guessing.${ofOwn(own, unseenPairs(own, unseen))}`
        : html``,
    };
  const [photo, touch] = [alike["answers/vis"], alike["answers/tac"]];
  const [lower, higher] = photo.share < touch.share ? [photo, touch] : [touch, photo];
  const share = (/** @type {Reading} */ reading) => percent(unseen.unseen[`answers/${reading}`]?.share);
  return {
    ...words,
    figure: html`<b>${percent(alike.pairs / pairs)}</b> of the unseen pairs look like another class.`,
    remark: html`${
      lower.high < higher.low
        ? `Where a photo deceives, only ${higher === touch ? "touch" : "the photo"} can tell.`
        : "The intervals of photo and touch overlap, so neither is surely ahead."
    } Mean of ${unseenDomains(own)}: photo ${share("vis")}, touch ${share("tac")}, both ${share("fused")}.${ofOwn(own, `${alike.pairs} look-alikes`)}`,
  };
}

/** What follows a chapter, and its words; the workbench has none, and the second chapter has its own.
 * @type {Record<string, {to: string, next: string, words?: (scene: Scene) => Words}>} */
export const LESSONS = {
  where: { to: "order", next: "Next →" },
  order: { words: order, to: "fooled", next: "Next →" },
  fooled: { words: fooled, to: "analyse", next: "Analyse →" },
};
