/** The tour: a question in each chapter, options, and the result. Every figure is one of the page's own. */

import { ends } from "../shared/numbers.js";
import { PLACES } from "../shared/tables.js";
import { html, percent } from "../shared/text.js";

const CLEAR = 0.1; // of accuracy: a smaller change over p is called small
const NEAR = 0.05; // quarter turns between an option and the best order
const ORDERS = [0.1, 0.35, 0.6]; // the options of the best order
/** Return how many bounds a value reaches. @param {number} value @param {...number} bounds */
const steps = (value, ...bounds) => bounds.filter((bound) => value >= bound).length;
/** Return the most pictures without labels that were measured. @param {Figures} at */
const most = ({ twins }) => Math.max(...twins.pictures);
/** Return the second chapter at one of its places. @param {number} place @returns {Partial<State>} */
const placed = (place) => ({ rung: PLACES.find(({ map }) => map === place)?.id });
/** What a step about one press opens with. @type {Partial<State>} */
const PRESS = { press: "", from: "0", dots: "", known: "0", reading: "tac" };

/** @param {number} share */
const b = (share) => html`<b>${percent(share)}</b>`;
/** @param {number[] | null} curve */
const known = (curve) => (curve ?? []).filter(Number.isFinite);
/** @param {number[] | null} curve */
const range = (curve) => (known(curve).length ? ends(known(curve))[1] - ends(known(curve))[0] : NaN);
/** @param {number[] | null} curve */
const within = (curve) => html`between ${ends(known(curve)).map((end, i) => [i > 0 && " and ", b(end)])}`;
/** @param {Figures} at */
const best = ({ curve, orders }) => orders[(curve ?? []).indexOf(ends(known(curve))[1])];

/** Return the share of the head that learned from the first sensor's touches, with its interval: away, by dots and
 * pictures.
 * @param {Figures} at */
const away = ({ twins }, dots = 0, pictures = 0) =>
  twins.away.touch[0][dots][Math.max(0, [0, ...twins.pictures].indexOf(pictures))];
/** Return its share at home: of [source][look][pictures][target], all the first, the share beside its interval.
 * @param {Figures} at */
const home = ({ twins }) => {
  const [[[[[share]]]]] = twins.accuracy.touch;
  return share;
};
/** Return how much of the loss filled dots bring back, from 0 to 1. @param {Figures} at */
const mended = (at) => (away(at, 1)[0] - away(at)[0]) / (home(at) - away(at)[0]);
/** Return what photo and touch alone read right of look-alikes, and whether that cannot tell them apart.
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
      html`A model was trained to recognise materials from the touches of one sensor. Seven other sensors image the same
        presses. What share of its own-sensor accuracy does it keep on them?`,
    options: ["Nearly all", "More than half", "Less than half"],
    right: (at) => [2 - steps(away(at)[0] / home(at), 0.5, 0.9)],
    reveal: (at) =>
      html`Its accuracy is ${b(home(at))} on its own sensor and ${b(away(at)[0])} on the seven others. Only the sensor
        differs.`,
  },
  {
    title: "The dots",
    chapter: "touch",
    needs: "twins",
    set: () => PRESS,
    ask: () =>
      html`Some sensors have dots printed on their gel. Now each dot gets the colours around it, in training and test.
        How much of the lost accuracy returns?`,
    options: ["Hardly any", "Less than half", "More than half"],
    right: (at) => [steps(mended(at), 0.1, 0.5)],
    after: () => ({ dots: "1" }),
    reveal: (at) =>
      html`Accuracy on new sensors rises from ${b(away(at)[0])} to ${b(away(at, 1)[0])}: the model had learned the
        dots. It was given nothing from the new sensors.`,
  },
  {
    title: "Without one label",
    chapter: "touch",
    needs: "twins",
    set: () => PRESS,
    ask: (at) =>
      html`Now the dots stay as they are, and ${most(at)} unlabelled pictures of each new sensor provide the mean and
        spread of each feature. Does this help more than filling the dots?`,
    options: ["More", "About as much", "Less"],
    right: (at) => {
      const [few, filled] = [away(at, 0, most(at)), away(at, 1)];
      return [few[1] > filled[2] ? 0 : few[2] < filled[1] ? 2 : 1];
    },
    after: (at) => ({ known: `${most(at)}` }),
    reveal: (at) =>
      html`Unlabelled pictures give ${b(away(at, 0, most(at))[0])}, filled dots ${b(away(at, 1)[0])}, and both
        together ${b(away(at, 1, most(at))[0])}.`,
  },
  {
    title: "p and the gaps",
    chapter: "gaps",
    needs: "gaps",
    ask: () =>
      html`Photos lie apart from touches, and sensors from one another. The slider turns all features by an order p.
        Does p close these two gaps?`,
    options: ["Yes, one of them or both", "No"],
    right: ({ gaps }) => [gaps.closed ? 0 : 1],
    reveal: ({ gaps, pale }) =>
      html`${gaps.words} ${
        known(pale).length > 0 && html`With a head trained at each p, accuracy on new sensors lies ${within(pale)}.`
      } Drag p and see.`,
  },
  {
    title: "Where they go",
    chapter: "where",
    needs: "places",
    set: () => placed(0),
    ask: () =>
      html`Each colour is a sensor, and the lines join one press as seen by all sensors. Suppose we align the means of
        all sensors. Does accuracy on new sensors recover?`,
    options: ["Mostly", "Hardly"],
    right: ({ places: { accuracy } }) => [accuracy[1] - accuracy[0] > 0.5 * (accuracy[2] - accuracy[0]) ? 0 : 1],
    after: () => placed(2),
    reveal: ({ places: { accuracy } }) =>
      html`Accuracy is ${b(accuracy[0])} with raw features, ${b(accuracy[1])} with aligned means,
        and ${b(accuracy[2])} with aligned means and spreads. Sensors shift features and stretch them.`,
  },
  {
    title: "When does p matter?",
    chapter: "order",
    ask: () =>
      html`Each colour is a kind of signal, and each stop of the slider shows a head trained at that p. At which p do
        the colours separate?`,
    options: [...ORDERS.map((p) => `Near ${p}`), "Equally at every p"],
    right: (at) =>
      range(at.curve) < CLEAR ? [3] : [...ORDERS.keys()].filter((i) => Math.abs(ORDERS[i] - best(at)) <= NEAR),
    after: (at) => (known(at.curve).length ? { p: best(at) } : {}),
    reveal: (at) =>
      known(at.curve).length
        ? html`Accuracy in unseen domains lies ${within(at.curve)} and is highest at
          p = <b>${best(at).toFixed(2)}</b>, where the chirp becomes one spike.`
        : html`These data cannot show it, because the training domain of the head or its accuracy is unknown.`,
  },
  {
    title: "When is touch needed?",
    chapter: "fooled",
    ask: () => html`Some photos look like another class. For these pairs, which image alone is correct more often?`,
    options: ["The photo", "The touch"],
    right: (at) => {
      const found = alone(at);
      return !found || found.doubt ? [] : [found.photo.share > found.touch.share ? 0 : 1];
    },
    after: () => ({ reading: "tac" }),
    reveal: (at) => {
      const found = alone(at);
      return found
        ? html`For the <b>${found.pairs}</b> pairs of this kind, the photo alone is correct
          in ${b(found.photo.share)} and the touch alone
          in ${b(found.touch.share)}.${found.doubt && " The intervals overlap, so neither is clearly better."}`
        : html`No pair of this set looks like another class.`;
    },
  },
  {
    title: "Why does the model fail on the next sensor?",
    chapter: "touch",
    needs: "twins",
    set: (at) => ({ ...PRESS, dots: "1", known: `${most(at)}` }),
    reveal: (at) => answer(at),
  },
];

/** Return the title's answer in sentences of the page's own figures: what failed, what mended it, what p does.
 * @param {Figures} at */
export const answer = (at) =>
  html`It learned its sensor together with the materials: on another sensor, accuracy is ${b(away(at)[0])} instead
    of ${b(home(at))}. ${
      mended(at) > 0.5 && "Most of the loss comes from the dots printed on its gel. "
    }With filled dots, accuracy is ${b(away(at, 1)[0])}; with ${most(at)} unlabelled pictures as
    well, ${b(away(at, 1, most(at))[0])}.${
      known(at.pale).length > 0 &&
      html` Over all values of p, accuracy lies ${within(at.pale)} on the sensors and ${within(at.curve)} on the
        chirps.`
    }`;
