/** The tour's six steps: settings, question, and result. */

import { asText, values } from "../shared/measures.js";
import { percent } from "../shared/text.js";

const ALL = { domain: "", class: "", modality: "", alike: "", find: "", range: "", cell: "" }; // no filter hides a step's subject
const NAMES = { relu: "F, after the ReLU", f_bar: "F̄, after attention", f_hat: "F̂, after the tree" };
const READINGS = { fused: "both", vis: "photo only", tac: "touch only" };
const CLEAR = 0.1; // of accuracy: a smaller change over p is called small

const b = (text) => `<b>${text}</b>`;
const ends = (all) => [Math.min(...all), Math.max(...all)];

/**
 * `at` gives values from the screen: gap(measure, stage), order, unseen, toy, curve (accuracy over
 * stops), orders, kind. A step is {title, set, look, ask, options, right(at), reveal(at)}; look is
 * what has to be in view, options are
 * [key, words], `right` returns the key of the correct one, or several keys; none if the set cannot decide.
 */
export const STEPS = [
  {
    title: "The modality gap",
    look: ".maps",
    set: { stage: "raw", colour: "modality", map: "pca", part: "curves", means: "1", ...ALL },
    ask: ({ signals }) =>
      signals
        ? "● is one recording of a signal (VIS), ▲ another one (TAC). Does the encoder place the two close together?"
        : "● is a photo, ▲ the touch of the same surface. Does the encoder place the two close together?",
    options: [
      ["near", "Close together"],
      ["far", "Apart"],
    ],
    right: (at) => (at.gap("modality_gap", "raw") > 0.25 ? "far" : "near"),
    reveal: (at) =>
      `The mean directions of ${at.signals ? "VIS and TAC" : "photos and touches"} are ${b(at.gap("modality_gap", "raw").toFixed(2))} apart (0: the same, 2: opposite). This is the ${b("modality gap")}: the thick lines on the map.`,
  },
  {
    title: "The domain gap",
    look: ".maps",
    set: { stage: "raw", colour: "domain", map: "pca", part: "curves", means: "1", ...ALL },
    ask: ({ signals }) =>
      `Each colour is now a ${b("domain")}: ${signals ? "recordings with the same kind of interference" : "a sensor and its data set"}. What separates points more: the domain or the class?`,
    options: [
      ["domain", "The domain"],
      ["class", "The class"],
    ],
    right: (at) =>
      oneDomain(at) ? [] : at.gap("domain_gap", "raw") > at.gap("margin", "raw") ? "domain" : "class",
    reveal: (at) =>
      oneDomain(at)
        ? "This set has one domain, so it has no domain gap."
        : `Two domains are ${b(at.gap("domain_gap", "raw").toFixed(2))} apart on average: the ${b("domain gap")}. Classes differ by a cosine of ${b(at.gap("margin", "raw").toFixed(2))}. The head learns from ${b(at.unseen.source)} alone and meets the others as strangers.`,
  },
  {
    title: "What p does, on a toy",
    look: ".toy",
    set: { part: "toy", stage: "frft", mode: "moved", ...ALL }, // heads of other modes differ in their projection
    ask: "Drag p and watch the two signals. When does the distance between them change?",
    options: [
      ["neither", "Never"],
      ["relu", "Only after the ReLU"],
      ["both", "After both"],
    ],
    right: (_) => "relu",
    reveal: ({ toy }) => {
      const [low, high] = ends(toy.distances.signals.clipped);
      return `The transform rotates: it keeps the distance ${b(toy.distances.signals.turned[0].toFixed(2))} at every p. The ReLU clips, and the distance then lies between ${b(low.toFixed(2))} and ${b(high.toFixed(2))}. On the real map of Fₚ, nothing moves either.`;
    },
  },
  {
    title: "A small gap is not a good head",
    look: ".staircase",
    set: { part: "curves", stage: "f_bar", colour: "class", gap: "modality_gap", ...ALL },
    ask: "Look at the staircase. At which step is the modality gap smallest?",
    options: Object.entries(NAMES),
    right: (at) => smallest(at),
    reveal: (at) => {
      const steps = smallest(at);
      const step = steps.at(-1);
      const [gap, margin, before, last] = [
        at.gap("modality_gap", step),
        ...[step, "frft", "f_hat"].map((one) => at.gap("margin", one)),
      ];
      const start = `At ${steps.map((one) => NAMES[one]).join(" and ")}: ${b(gap.toFixed(2))}. The cosine margin between classes is ${b(margin.toFixed(2))} there`;
      const together =
        margin < before
          ? "the classes have moved together, too, and the tree spreads them again"
          : "the classes are still close together, and the tree spreads them";
      return step !== "f_hat" && margin < last
        ? `${start}, against ${b(last.toFixed(2))} at F̂: ${together}. So read a gap beside margin and accuracy.`
        : `${start}. A gap alone means little: read it beside margin and accuracy.`;
    },
  },
  {
    title: "Does p matter?",
    look: ".curves",
    set: { part: "curves", stage: "f_hat", ...ALL },
    ask: ({ kind }) =>
      kind === "retrained"
        ? "Each stop is a head trained at that p. Drag p. Does accuracy on unseen domains depend on it?"
        : "The weights stay and only p moves. Drag p. Does accuracy on unseen domains depend on it?",
    options: [
      ["little", "Hardly"],
      ["much", "A lot"],
    ],
    right: ({ curve }) =>
      !curve ? [] : ends(known(curve))[1] - ends(known(curve))[0] >= CLEAR ? "much" : "little",
    reveal: ({ curve, orders, kind }) => {
      if (!curve)
        return "These frames have no accuracy on unseen domains; make them again with <code>omnivat sweep</code>.";
      const [low, high] = ends(known(curve));
      const at = (v) => orders[curve.indexOf(v)].toFixed(2);
      const range = `Accuracy on unseen domains ranges from ${b(percent(low))} (p = ${at(low)}) to ${b(percent(high))} (p = ${at(high)})`;
      if (kind !== "retrained")
        return `${range}: the weights fit only the p they were trained with. This does not show how well a head trained at another p does.`;
      return high - low < CLEAR
        ? `${range}. Heads trained at any p do about equally well here.`
        : `${range}. On this set the right p decides.`;
    },
  },
  {
    title: "Meeting strangers",
    look: ".strangers",
    set: { part: "strangers", reading: "fused", stage: "f_hat", colour: "domain", ...ALL },
    ask: "In unseen domains, which is right most often?",
    options: Object.entries(READINGS),
    right: ({ unseen }) => best(unseen),
    reveal: ({ unseen }) => {
      const own = (key) => unseen.unseen[`answers/${key}`];
      const shares = Object.entries(READINGS).map(([key, words]) => `${words} ${b(percent(own(key).share))}`);
      const first = best(unseen);
      const close = Object.keys(READINGS).filter((key) => key !== first && own(key).high > own(first).low);
      const doubt = close.length
        ? ` The intervals of ${listed([first, ...close].map((key) => READINGS[key]))} overlap.`
        : "";
      return `Right: ${shares.join(", ")}; guessing ${percent(unseen.chance)}.${doubt} The bars show each domain; the source, ${b(unseen.source)}, is marked. Where data are simulated, none of this is a result on real sensors.`;
    },
  },
];

/** Words in one list: "both, photo only and touch only". */
const listed = (words) => `${words.slice(0, -1).join(", ")} and ${words.at(-1)}`;
const oneDomain = (at) => !Number.isFinite(at.gap("domain_gap", "raw"));
const known = (curve) => curve.filter(Number.isFinite);
/** The steps with the smallest modality gap, as it is written. */
const smallest = (at) => {
  const written = (step) => at.gap("modality_gap", step).toFixed(2);
  const least = Object.keys(NAMES).map(written).sort()[0];
  return Object.keys(NAMES).filter((step) => written(step) === least);
};
const best = (unseen) =>
  Object.keys(READINGS).reduce((most, key) =>
    unseen.unseen[`answers/${key}`].share > unseen.unseen[`answers/${most}`].share ? key : most,
  );

/** The values on the screen for the current frames. */
export function onScreen(frames, p, facts) {
  const stop = frames.stop(p);
  return {
    ...facts,
    kind: frames.kind,
    signals: frames.signals,
    orders: frames.orders,
    curve: values(frames, "accuracy", "f_hat"),
    gap: (measure, stage) => values(frames, measure, stage)?.[stop] ?? NaN,
    text: (measure, stage) => asText(measure, values(frames, measure, stage)?.[stop], 2),
  };
}
