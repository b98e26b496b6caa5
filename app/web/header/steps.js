/** The tour: a question in each chapter, options, and what is then told. Every figure is one of the page's own. */

import { values } from "../shared/measures.js";
import { percent } from "../shared/text.js";

const CLEAR = 0.1; // of accuracy: a smaller change over p is called small
const NEAR = 0.05; // quarter turns between an option and the best order
const MOST = 200; // pictures without labels
const READINGS = { vis: "The photo", tac: "The touch" };

const b = (text) => `<b>${text}</b>`;
const known = (curve) => (curve ?? []).filter(Number.isFinite);
/** @type {(curve: number[]) => [number, number]} */
const ends = (curve) => [Math.min(...known(curve)), Math.max(...known(curve))];
const ranges = (curve) => (known(curve).length ? ends(curve)[1] - ends(curve)[0] : NaN);
const best = ({ curve, orders }) => orders[curve.indexOf(ends(curve)[1])];
const within = ([low, high]) => `between ${b(percent(low))} and ${b(percent(high))}`;
const overlap = (one, other) => one.low <= other.high && other.low <= one.high;
const missing = "These data cannot tell: the head's source or its accuracy is not known here.";

/** [share, low, high] of the head that learned from the first sensor's touches: away, by dots and pictures; at home. */
export const away = ({ twins }, dots = 0, pictures = 0) =>
  twins.away.touch[0][dots][Math.max(0, [0, ...twins.pictures].indexOf(pictures))];
export const home = ({ twins }) => twins.accuracy.touch[0][0][0][0];

/** How much of the loss filled dots bring back, from 0 to 1. */
const mended = (at) => (away(at, 1)[0] - away(at)[0]) / (home(at)[0] - away(at)[0]);

/**
 * `at` gives the figures: twins and places (what heads predict of the twins, and their map; null in a saved page), curve
 * and orders (accuracy over p on the chirps), pale (that on the sensors), unseen (facts about the loaded head). A step
 * is {title, chapter, needs, set, ask, options, right, after, reveal}; without `ask` it tells only. `needs` names the
 * figure without which it is left out, `set` what the chapter opens with. `right(at)` returns the keys that are right,
 * or none if the data cannot decide.
 * @type {any[]}
 */
export const STEPS = [
  {
    title: "One touch",
    chapter: "touch",
    needs: "twins",
    set: { press: "", from: "0", dots: "", known: "0", reading: "tac" },
    ask: "A model learned materials from the first sensor’s touches. Seven others image the same presses. Of what it reads right at home, how much does it still read?",
    options: [
      ["most", "Nearly all"],
      ["part", "More than half"],
      ["less", "Less than half"],
    ],
    right: (at) => {
      const left = away(at)[0] / home(at)[0];
      return [left > 0.9 ? "most" : left < 0.5 ? "less" : "part"];
    },
    reveal: (at) =>
      `${b(percent(home(at)[0]))} on its own sensor, ${b(percent(away(at)[0]))} on the seven others. Only the sensor changed.`,
  },
  {
    title: "The dots",
    chapter: "touch",
    needs: "twins",
    set: { press: "", from: "0", dots: "", known: "0", reading: "tac" },
    ask: "Dots are printed on some gels. Now each dot takes the colours around it, in training too. How much of the loss comes back?",
    options: [
      ["little", "Hardly any"],
      ["part", "Less than half"],
      ["most", "More than half"],
    ],
    right: (at) => [mended(at) < 0.1 ? "little" : mended(at) < 0.5 ? "part" : "most"],
    after: () => ({ dots: "1" }),
    reveal: (at) =>
      `${b(percent(away(at, 1)[0]))} in place of ${b(percent(away(at)[0]))}: the head had learned the dots. Nothing was known of the new sensors.`,
  },
  {
    title: "Without one label",
    chapter: "touch",
    needs: "twins",
    set: { press: "", from: "0", dots: "", known: "0", reading: "tac" },
    ask: `Instead, ${MOST} pictures of each new sensor give the mean and spread of each feature; no label is used. Does that bring more than filled dots?`,
    options: [
      ["more", "More"],
      ["same", "About as much"],
      ["less", "Less"],
    ],
    right: (at) => {
      const [few, filled] = [away(at, 0, MOST), away(at, 1)];
      return few[1] > filled[2] ? ["more"] : few[2] < filled[1] ? ["less"] : ["same"];
    },
    after: () => ({ known: String(MOST) }),
    reveal: (at) =>
      `${b(percent(away(at, 0, MOST)[0]))}; filled dots bring ${b(percent(away(at, 1)[0]))}, and both together ${b(percent(away(at, 1, MOST)[0]))}.`,
  },
  {
    title: "Where they go",
    chapter: "where",
    needs: "places",
    set: { rung: "0" },
    ask: "Each colour is a sensor, and a thread joins one press. Suppose each sensor’s mean is taken away. Does the head read its touches again?",
    options: [
      ["yes", "Mostly"],
      ["no", "Not yet"],
    ],
    right: ({ places: { accuracy } }) => [accuracy[1] - accuracy[0] > 0.5 * (accuracy[2] - accuracy[0]) ? "yes" : "no"],
    after: () => ({ rung: "2" }),
    reveal: ({ places: { accuracy } }) =>
      `${b(percent(accuracy[0]))} as they come, ${b(percent(accuracy[1]))} with the mean moved, ${b(percent(accuracy[2]))} with mean and spread: sensors shift features and stretch them.`,
  },
  {
    title: "The order p on touch",
    chapter: "where",
    needs: "pale",
    set: { rung: "0" },
    ask: "The slider turns all features by an order p; each stop has heads of its own. How far does accuracy on new sensors range?",
    options: [
      ["much", "Over ten points"],
      ["little", "Less"],
    ],
    right: (at) => [ranges(at.pale) >= CLEAR ? "much" : "little"],
    after: () => ({ rung: "p" }),
    reveal: (at) => `It lies ${within(ends(at.pale))}. Drag p: the points and both gaps move all the same.`,
  },
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
        ? `Accuracy in unseen domains lies ${within(ends(at.curve))}; the best order is p = ${b(best(at).toFixed(2))}. There the chirp is sharp.`
        : missing,
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
    after: () => ({ reading: "tac" }),
    reveal: ({ unseen: { look_alikes: alike } }) => {
      if (!alike) return "No pair of this set looks like another class.";
      const [photo, touch] = ["vis", "tac"].map((name) => alike[`answers/${name}`]);
      const doubt = overlap(photo, touch) ? " Their intervals overlap, so neither is surely ahead." : "";
      return `On ${b(alike.pairs)} such pairs the photo is right in ${b(percent(photo.share))}, the touch in ${b(percent(touch.share))}.${doubt}`;
    },
  },
  {
    title: "Why does it fail on the next sensor?",
    chapter: "touch",
    needs: "twins",
    set: { dots: "1", known: String(MOST), reading: "tac", from: "0" },
    reveal: (at) => answer(at),
  },
];

/** The title's answer in sentences of the page's own figures: what failed, what mended it, what p does. */
export function answer(at) {
  const dots =
    mended(at) > 0.5 ? "Most of that were the dots printed on its gel: filled" : "With the printed dots filled";
  const more = ` ${dots}, it reads ${b(percent(away(at, 1)[0]))}, and with ${MOST} pictures without labels ${b(percent(away(at, 1, MOST)[0]))}.`;
  const order = known(at.pale).length
    ? ` Over all orders p, accuracy lies ${within(ends(at.pale))} on the sensors, ${within(ends(at.curve))} on the chirps.`
    : "";
  return `It had learned its sensor together with the materials: on another one it reads ${b(percent(away(at)[0]))} instead of ${b(percent(home(at)[0]))}.${more}${order}`;
}

/** The figures for the steps. */
export const onScreen = (frames, more) => ({
  ...more,
  orders: frames.orders,
  curve: values(frames, "accuracy", "f_hat"),
});
