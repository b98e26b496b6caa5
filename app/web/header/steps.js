/** The tour: six steps through the chapters. A step has a chapter, a question, options and what is then told. */

import { values } from "../shared/measures.js";
import { percent } from "../shared/text.js";

const CLEAR = 0.1; // of accuracy: a smaller change over p is called small
const NEAR = 0.05; // quarter turns between an option and the best order
const READINGS = { vis: "The photo", tac: "The touch" };

const points = (v) => `${v < 0 ? "−" : "+"}${Math.abs(100 * v).toFixed(1)}`;
const b = (text) => `<b>${text}</b>`;
const known = (curve) => (curve ?? []).filter(Number.isFinite);
/** @type {(curve: number[]) => [number, number]} */
const ends = (curve) => [Math.min(...known(curve)), Math.max(...known(curve))];
const ranges = (curve) => (known(curve).length ? ends(curve)[1] - ends(curve)[0] : NaN);
const best = ({ curve, orders }) => orders[curve.indexOf(ends(curve)[1])];
const within = ([low, high]) => `between ${b(percent(low))} and ${b(percent(high))}`;
const home = ({ unseen }) => unseen.domains.find(({ is_source }) => is_source)?.["answers/fused"];
const away = ({ unseen }) => unseen.unseen["answers/fused"];
const overlap = (one, other) => one.low <= other.high && other.low <= one.high;
const missing = "These data cannot tell: the head's source or its accuracy is not known here.";

/**
 * `at` gives the figures: curve and orders (accuracy over p of the first chapter's set), pale (that of the other
 * set), unseen (facts about the loaded head), gaps (domain gap as it comes, centred), rungs (the ladder of the loaded
 * head), records (gains of 20 pictures on heads from other sources), classes. A step is {title, chapter, set, ask,
 * options, right, reveal}. `right(at)` returns the keys that are right, or none if the data cannot decide.
 */
export const STEPS = [
  {
    title: "When does p decide?",
    chapter: "order",
    ask: "Each colour is a kind of signal, each stop of the slider a head trained at that p. Where do the colours come apart?",
    options: [
      ["low", "Near 0.1"],
      ["mid", "Near 0.35"],
      ["high", "Near 0.6"],
      ["all", "Everywhere alike"],
    ],
    right: (at) => {
      if (!known(at.curve).length) return [];
      if (ranges(at.curve) < CLEAR) return ["all"];
      const near = { low: 0.1, mid: 0.35, high: 0.6 };
      return Object.keys(near).filter((key) => Math.abs(near[key] - best(at)) <= NEAR);
    },
    after: (at) => (known(at.curve).length ? { p: best(at) } : {}),
    reveal: (at) =>
      known(at.curve).length
        ? `Accuracy in unseen domains lies ${within(ends(at.curve))}; the best order is p = ${b(best(at).toFixed(2))}. The map now shows it.`
        : missing,
  },
  {
    title: "And on touch sensors?",
    chapter: "order",
    ask: "The same heads, trained on photos and touches. How much does accuracy range over p there?",
    options: [
      ["much", "As much"],
      ["little", "Hardly"],
    ],
    right: (at) => (known(at.pale).length ? [ranges(at.pale) >= CLEAR ? "much" : "little"] : []),
    reveal: (at) =>
      known(at.pale).length
        ? `It lies ${within(ends(at.pale))}: the grey curve. An order decides only where the data hold a signal of that order.`
        : "There is no second set here to compare with.",
  },
  {
    title: "The next sensor",
    chapter: "failure",
    ask: "A head learned from one sensor, the source. How much of its accuracy is left on sensors it never met?",
    options: [
      ["most", "More than nine tenths"],
      ["part", "Between half and nine tenths"],
      ["less", "Less than half"],
    ],
    right: (at) => {
      if (!home(at) || !away(at)) return [];
      const left = away(at).share / home(at).share;
      return [left > 0.9 ? "most" : left < 0.5 ? "less" : "part"];
    },
    reveal: (at) =>
      home(at) && away(at)
        ? `${b(percent(home(at).share))} at home, ${b(percent(away(at).share))} away: each colour is a sensor, and each lies at a place of its own.`
        : missing,
  },
  {
    title: "Without one label",
    chapter: "failure",
    ask: "Take from each sensor the mean of its own pictures; no label is needed. What becomes of the distance between sensors?",
    options: [
      ["same", "It stays"],
      ["gone", "It shrinks to a small part"],
    ],
    right: (at) => (at.gaps?.[0] ? [at.gaps[1] < 0.5 * at.gaps[0] ? "gone" : "same"] : []),
    after: () => ({ rung: "1" }),
    reveal: (at) =>
      at.gaps?.[0]
        ? `Their mean distance falls from ${b(at.gaps[0].toFixed(2))} to ${b(at.gaps[1].toFixed(2))}: much of what differs between sensors is one offset of all pictures.`
        : "This set has one domain, or is too large to centre here.",
  },
  {
    title: "When is touch needed?",
    chapter: "fooled",
    ask: "Some things look like another class. For them, which is right more often on its own?",
    options: Object.entries(READINGS),
    right: ({ unseen: { look_alikes: alike } }) => {
      if (!alike || overlap(alike["answers/vis"], alike["answers/tac"])) return [];
      return [alike["answers/vis"].share > alike["answers/tac"].share ? "vis" : "tac"];
    },
    reveal: ({ unseen: { look_alikes: alike } }) => {
      if (!alike) return "No pair of this set looks like another class.";
      const [photo, touch] = ["vis", "tac"].map((name) => alike[`answers/${name}`]);
      const doubt = overlap(photo, touch) ? " Their intervals overlap, so neither is surely ahead." : "";
      return `On ${b(alike.pairs)} such pairs the photo is right in ${b(percent(photo.share))}, the touch in ${b(percent(touch.share))}.${doubt}`;
    },
  },
  {
    title: "Why does it fail on the next sensor?",
    chapter: "failure",
    ask: "The sensors' offsets can be taken away without a label. Is accuracy away from home surely higher then?",
    options: [
      ["yes", "Surely higher"],
      ["no", "Not surely"],
    ],
    climbs: true, // waits for the ladder
    right: (at) => (away(at) && profiled(at) ? [profiled(at).low > away(at).high ? "yes" : "no"] : []),
    after: () => ({ rung: "1" }),
    reveal: (at) => answer(at),
  },
];

/** The loaded head's accuracy away from home once 20 pictures of each new sensor give its offset, if computed. */
const profiled = ({ rungs = [] }) => rungs.find(({ rung, from }) => rung === "n20" && from === "this head") ?? null;

/** What that brings: on this head with its intervals, and on heads from other sensors, from the records. */
function brings(at) {
  const [mine, here] = [profiled(at), away(at)];
  if (!mine || !here) return "";
  const sure = mine.low > here.high || mine.high < here.low ? "" : ", so this is not sure";
  const others = (at.records ?? []).filter(Number.isFinite);
  const mean = others.reduce((sum, v) => sum + v, 0) / others.length;
  const elsewhere = others.length
    ? `; light heads from ${others.length} other sources, in the records, gain ${b(points(mean))} points on average (${points(Math.min(...others))} to ${points(Math.max(...others))})`
    : "";
  return ` With 20 pictures and no labels this head is right in ${b(percent(mine.accuracy))} (${percent(mine.low)} to ${percent(mine.high)}, before ${percent(here.low)} to ${percent(here.high)}${sure})${elsewhere}.`;
}

/** The title's answer in sentences of the page's own figures: how it fails, what centring brings, what p does. */
export function answer(at) {
  const [there, here] = [home(at), away(at)];
  const failed =
    there && here
      ? `On sensors it never met the head is right in ${b(percent(here.share))} instead of ${b(percent(there.share))}`
      : "How much it fails is not known here";
  const offset = at.gaps?.[0]
    ? `; each sensor shifts all its pictures, and without those shifts sensors lie ${b(at.gaps[1].toFixed(2))} apart instead of ${b(at.gaps[0].toFixed(2))}`
    : "";
  const order = known(at.pale).length
    ? ` Over all orders p, accuracy lies ${within(ends(at.pale))} on the sensors, ${within(ends(at.curve))} on the chirps.`
    : known(at.curve).length
      ? ` Over all orders p, accuracy lies ${within(ends(at.curve))}.`
      : "";
  return `${failed}${offset}.${brings(at)}${order}`;
}

/** The figures for the steps. */
export const onScreen = (frames, more) => ({
  ...more,
  orders: frames.orders,
  curve: values(frames, "accuracy", "f_hat"),
});
