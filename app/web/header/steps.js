/** The tour: a question in each chapter, options, and what is then told. Every figure is one of the page's own. */

import { BY_ORDER, PLACES } from "../shared/tables.js";
import { html, percent } from "../shared/text.js";

const CLEAR = 0.1; // of accuracy: a smaller change over p is called small
const NEAR = 0.05; // quarter turns between an option and the best order
const ORDERS = [0.1, 0.35, 0.6]; // the options of the best order
/** How many bounds a value reaches. @param {number} value @param {...number} bounds */
const steps = (value, ...bounds) => bounds.filter((bound) => value >= bound).length;
/** The most pictures without labels that were measured. @param {Figures} at */
const most = ({ twins }) => Math.max(...twins.pictures);
/** The second chapter at one of its places. @param {number} place @returns {Partial<State>} */
const placed = (place) => ({ rung: PLACES.find(({ map }) => map === place)?.id });
/** What a step about one press opens with. @type {Partial<State>} */
const PRESS = { press: "", from: "0", dots: "", known: "0", reading: "tac" };

/** @param {number} share */
const b = (share) => html`<b>${percent(share)}</b>`;
/** @param {number[] | null} curve */
const known = (curve) => (curve ?? []).filter(Number.isFinite);
/** @param {number[] | null} curve @returns {[number, number]} */
const ends = (curve) => [Math.min(...known(curve)), Math.max(...known(curve))];
/** @param {number[] | null} curve */
const range = (curve) => (known(curve).length ? ends(curve)[1] - ends(curve)[0] : NaN);
/** @param {number[] | null} curve */
const within = (curve) => html`between ${b(ends(curve)[0])} and ${b(ends(curve)[1])}`;
/** @param {Figures} at */
const best = ({ curve, orders }) => orders[(curve ?? []).indexOf(ends(curve)[1])];

/** The share of the head that learned from the first sensor's touches, with its interval: away, by dots and pictures.
 * @param {Figures} at */
const away = ({ twins }, dots = 0, pictures = 0) =>
  twins.away.touch[0][dots][Math.max(0, [0, ...twins.pictures].indexOf(pictures))];
/** Its share at home. @param {Figures} at */
const home = ({ twins }) => twins.accuracy.touch[0][0][0][0][0];
/** How much of the loss filled dots bring back, from 0 to 1. @param {Figures} at */
const mended = (at) => (away(at, 1)[0] - away(at)[0]) / (home(at) - away(at)[0]);
/** What photo and touch alone read right of look-alikes, and whether that cannot tell them apart.
 * @param {Figures} at */
function alone({ unseen: { look_alikes: alike } }) {
  if (!alike) return null;
  const [photo, touch] = [alike["answers/vis"], alike["answers/tac"]];
  return { pairs: alike.pairs, photo, touch, doubt: photo.low <= touch.high && touch.low <= photo.high };
}

/** @type {TourStep[]} */
export const STEPS = [
  {
    title: "One touch",
    chapter: "touch",
    needs: "twins",
    set: () => PRESS,
    ask: () =>
      "A model learned materials from the first sensor’s touches. Seven others image the same presses. Of what it reads right at home, how much does it still read?",
    options: ["Nearly all", "More than half", "Less than half"],
    right: (at) => [2 - steps(away(at)[0] / home(at), 0.5, 0.9)],
    reveal: (at) =>
      html`${b(home(at))} on its own sensor, ${b(away(at)[0])} on the seven others. Only the sensor changed.`,
  },
  {
    title: "The dots",
    chapter: "touch",
    needs: "twins",
    set: () => PRESS,
    ask: () =>
      "Dots are printed on some gels. Now each dot takes the colours around it, in training too. How much of the loss comes back?",
    options: ["Hardly any", "Less than half", "More than half"],
    right: (at) => [steps(mended(at), 0.1, 0.5)],
    after: () => ({ dots: "1" }),
    reveal: (at) =>
      html`${b(away(at, 1)[0])} in place of ${b(away(at)[0])}: the head had learned the dots. Nothing was known of the new sensors.`,
  },
  {
    title: "Without one label",
    chapter: "touch",
    needs: "twins",
    set: () => PRESS,
    ask: (at) =>
      `Instead, ${most(at)} pictures of each new sensor give the mean and spread of each feature; no label is used. Does that bring more than filled dots?`,
    options: ["More", "About as much", "Less"],
    right: (at) => {
      const [few, filled] = [away(at, 0, most(at)), away(at, 1)];
      return [few[1] > filled[2] ? 0 : few[2] < filled[1] ? 2 : 1];
    },
    after: (at) => ({ known: `${most(at)}` }),
    reveal: (at) =>
      html`${b(away(at, 0, most(at))[0])}; filled dots bring ${b(away(at, 1)[0])}, and both together ${b(away(at, 1, most(at))[0])}.`,
  },
  {
    title: "Where they go",
    chapter: "where",
    needs: "places",
    set: () => placed(0),
    ask: () =>
      "Each colour is a sensor, and a thread joins one press. Suppose each sensor’s mean is taken away. Does the head read its touches again?",
    options: ["Mostly", "Not yet"],
    right: ({ places: { accuracy } }) => [accuracy[1] - accuracy[0] > 0.5 * (accuracy[2] - accuracy[0]) ? 0 : 1],
    after: () => placed(2),
    reveal: ({ places: { accuracy } }) =>
      html`${b(accuracy[0])} as they come, ${b(accuracy[1])} with the mean moved, ${b(accuracy[2])} with mean and spread: sensors shift features and stretch them.`,
  },
  {
    title: "The order p on touch",
    chapter: "where",
    needs: "pale",
    set: () => placed(0),
    ask: () =>
      "The slider turns all features by an order p; each stop has heads of its own. How far does accuracy on new sensors range?",
    options: ["Over ten points", "Less"],
    right: ({ pale }) => [range(pale) >= CLEAR ? 0 : 1],
    after: () => ({ rung: BY_ORDER }),
    reveal: ({ pale }) => html`It lies ${within(pale)}. Drag p: the points and both gaps move all the same.`,
  },
  {
    title: "When does p decide?",
    chapter: "order",
    ask: () =>
      "Each colour is a kind of signal, each stop of the slider a head trained at that p. Where do the colours come apart?",
    options: [...ORDERS.map((p) => `Near ${p}`), "Everywhere alike"],
    right: (at) =>
      range(at.curve) < CLEAR ? [3] : [...ORDERS.keys()].filter((i) => Math.abs(ORDERS[i] - best(at)) <= NEAR),
    after: (at) => (known(at.curve).length ? { p: best(at) } : {}),
    reveal: (at) =>
      known(at.curve).length
        ? html`Accuracy in unseen domains lies ${within(at.curve)}; the best order is p = <b>${best(at).toFixed(2)}</b>. There the chirp is sharp.`
        : html`These data cannot tell: the head's source or its accuracy is not known here.`,
  },
  {
    title: "When is touch needed?",
    chapter: "fooled",
    ask: () => "Some things look like another class. For them, which is right more often on its own?",
    options: ["The photo", "The touch"],
    right: (at) => {
      const found = alone(at);
      return !found || found.doubt ? [] : [found.photo.share > found.touch.share ? 0 : 1];
    },
    after: () => ({ reading: "tac" }),
    reveal: (at) => {
      const found = alone(at);
      return found
        ? html`On <b>${found.pairs}</b> such pairs the photo is right in ${b(found.photo.share)}, the touch in ${b(found.touch.share)}.${found.doubt && " Their intervals overlap, so neither is surely ahead."}`
        : html`No pair of this set looks like another class.`;
    },
  },
  {
    title: "Why does it fail on the next sensor?",
    chapter: "touch",
    needs: "twins",
    set: (at) => ({ ...PRESS, dots: "1", known: `${most(at)}` }),
    reveal: (at) => answer(at),
  },
];

/** The title's answer in sentences of the page's own figures: what failed, what mended it, what p does.
 * @param {Figures} at */
export const answer = (at) =>
  html`It had learned its sensor together with the materials: on another one it reads ${b(away(at)[0])} instead of ${b(home(at))}. ${
    mended(at) > 0.5 ? "Most of that were the dots printed on its gel: filled" : "With the printed dots filled"
  }, it reads ${b(away(at, 1)[0])}, and with ${most(at)} pictures without labels ${b(away(at, 1, most(at))[0])}.${
    known(at.pale).length > 0 &&
    html` Over all orders p, accuracy lies ${within(at.pale)} on the sensors, ${within(at.curve)} on the chirps.`
  }`;
