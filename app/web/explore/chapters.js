/** The words and figures of the chapters, made from what is on the screen. */

import { remedyHtml } from "../shared/headless.js";
import { MEASURES, values } from "../shared/measures.js";
import { ofFrames, strangers, unseenPairs } from "../shared/provenance.js";
import { escaped, percent } from "../shared/text.js";
import { whole } from "./curves.js";
import { inWords } from "./strangers.js";

export const CLEAR = 0.1; // of accuracy: a smaller change over p is called small
const AWAY = 0.8; // the order at which the first chapter opens if p decides: most heads fail there
const b = (text) => `<b>${text}</b>`;
const known = (curve) => (curve ?? []).filter(Number.isFinite);
const plural = (n, one, many = `${one}s`) => `${inWords(n)} ${n === 1 ? one : many}`;

/** {best, range}: the order of the highest accuracy, and how far accuracy ranges over p; null if unknown. */
export function decided(frames) {
  const curve = values(frames, "accuracy", "f_hat");
  const all = known(curve);
  if (!all.length) return null;
  const [low, high] = [Math.min(...all), Math.max(...all)];
  return { best: frames.orders[curve.indexOf(high)], low, high, range: high - low };
}

/** The order at which a chapter opens. */
export function startOf(chapter, frames, own) {
  const at = Number.isFinite(own.learned) ? own.learned : 0.5;
  const wanted = chapter === "order" && (decided(frames)?.range ?? 0) >= CLEAR ? AWAY : at;
  return frames.orders[frames.stop(wanted)];
}

/** The accuracy at one stop, as HTML; one sentence on a screen. */
export function headOf(frames, stop) {
  const right = values(frames, "accuracy", "f_hat")?.[stop];
  if (!Number.isFinite(right)) return `<small>Unseen accuracy is unknown here: ${blind(frames)}</small>`;
  return `<b class="large">${percent(right)}</b> <span>right in ${where(frames)}</span>`;
}

const blind = ({ source, domains, labelled }) =>
  labelled === false
    ? "the pairs have no classes."
    : !source
      ? "the source of the head is not stated."
      : domains.includes(source)
        ? "there is no domain that the head has not seen."
        : `the head was trained on ${escaped(source)}, which is not in this set.`;

const where = (frames) => `${plural(strangers(frames), "unseen domain")}`;

/** Where the accuracy at one stop comes from; "" if it is not known. */
export const whence = (frames, stop, unseen) =>
  Number.isFinite(values(frames, "accuracy", "f_hat")?.[stop])
    ? ofFrames(frames, stop, unseenPairs(frames, unseen))
    : "";

/** The three measures of features without a head, and what a head would need. */
export function featuresHtml({ own, facts: { fit } }) {
  const rows = MEASURES.map(({ name, title, help }) => [title, help, values(own, name, "raw")?.[0]]);
  const shown = rows.filter(([, , value]) => Number.isFinite(value));
  const gaps = shown.map(([title, help, v]) => `<dt title="${help}">${title}</dt><dd>${v.toFixed(2)}</dd>`);
  return `<span class="measured"><b>The encoder’s features, no head.</b></span><dl class="gaps">${gaps.join("")}</dl>${headlessHtml(fit)}`;
}

const headlessHtml = (fit) =>
  fit?.problem
    ? `<details><summary>Why no head?</summary><p>${escaped(fit.problem)}</p></details>${remedyHtml(fit)}`
    : "";

function order({ frames, stop, facts: { unseen } }) {
  const facts = decided(frames);
  const figure = headOf(frames, stop);
  if (!facts) return { title: "When does the order p decide?", figure, remark: "Drag p: the map follows." };
  const kinds = `${inWords(frames.classes.length)} kinds of ${frames.signals ? "signal" : "pair"}`;
  if (facts.range < CLEAR)
    return {
      title: "On this set the order p hardly matters.",
      figure,
      whence: whence(frames, stop, unseen),
      remark: `Drag p. Accuracy stays between ${percent(facts.low)} and ${percent(facts.high)}.`,
    };
  const there = Math.abs(frames.orders[stop] - facts.best) < 0.026;
  return {
    title: there ? `At one order, ${kinds} come apart.` : `At which order do ${kinds} come apart?`,
    figure,
    whence: whence(frames, stop, unseen),
    remark: whole(frames)
      ? `Accuracy falls to ${percent(facts.low)} at worst. Grey: on touch sensors every order does about as well.`
      : "Drag <i>p</i> from end to end. Each stop is a head trained at that order.",
  };
}

function fooled({ own, facts: { unseen, fit } }) {
  const title = "When is touch needed?";
  if (own.headless) return { title: "Who is fooled? That takes a head.", figure: "", remark: headlessHtml(fit) };
  if (!unseen) return { title, figure: "", remark: "" };
  const alike = unseen.look_alikes;
  const pairs = unseen.domains.reduce((sum, one) => sum + (one.is_source ? 0 : one.pairs), 0);
  if (!alike)
    return {
      title: "Which domains fool the head?",
      figure: unseen.unseen["answers/fused"] ? "" : `Learned from ${escaped(own.source)}: ${blind(own)}`,
      remark: unseen.domains?.some((one) => one["answers/fused"])
        ? `Each bar has its 95 % interval. The thin line is guessing.${ofFrames(own, own.stop(own.learned), unseenPairs(own, unseen))}`
        : "",
    };
  const [photo, touch] = ["vis", "tac"].map((name) => alike[`answers/${name}`]);
  const [lower, higher] = photo.share < touch.share ? [photo, touch] : [touch, photo];
  const all = ["vis", "tac", "fused"].map((name) => percent(unseen.unseen[`answers/${name}`]?.share));
  const line = ofFrames(own, own.stop(own.learned), `${alike.pairs} look-alikes`);
  return {
    title,
    figure: `${b(percent(alike.pairs / pairs))} of the unseen pairs look like another class.`,
    remark: `${
      lower.high < higher.low
        ? `Where a photo deceives, only ${higher === touch ? "touch" : "the photo"} can tell.`
        : "The intervals of photo and touch overlap, so neither is surely ahead."
    } Mean of ${plural(strangers(own), "unseen domain")}: photo ${all[0]}, touch ${all[1]}, both ${all[2]}.${line}`,
  };
}

const CHAPTERS = {
  where: { to: "order", next: "Next →" },
  order: { words: order, to: "fooled", next: "Next →" },
  fooled: { words: fooled, to: "analyse", next: "Analyse →" },
};

/** {words(scene), to, next} of a chapter; undefined for the workbench. */
export const chapterNamed = (chapter) => CHAPTERS[chapter];
