/** Explore as one object, beside the address, and what each event makes of it: the values that change. No DOM here. */

import { UNSEEN, wantedPoints } from "./scene.js";

const UNKNOWN = { unseen: null, pairs: null, fit: null };

/** The set and its frames are there once a chapter with a map was opened. */
export const START = /** @type {Scene} */ (
  /** @type {Partial<Scene>} */ ({
    sets: [],
    first: "",
    chapter: "",
    mode: "",
    wanted: "",
    facts: UNKNOWN,
    known: {},
    dragged: new Map(),
    sample: -1,
    confident: 0,
    lasso: false,
    stairs: "",
    other: null,
    votes: null,
    twin: -1,
    alone: -1,
    glided: "",
    trail: [],
    opening: null,
    chosen: { key: "", pair: {}, row: -1, journey: null, note: "" },
    node: -1,
    pointer: [0, 0],
  })
);

/** @template {keyof SceneEvents} Name
 * @typedef {(scene: Scene, detail: SceneEvents[Name], address: State) => Partial<Scene>} Reducer */
/** @type {{[Name in keyof SceneEvents]: Reducer<Name>}} */
const EVENTS = {
  /** What is there now, and nothing follows from it. */
  arrived: (_, parts) => parts,
  /** Another set: nothing of the one before stays. */
  loaded: (_, { set, own, sprite, modes }) => ({
    ...{ set, own, sprite, modes, frames: own, facts: UNKNOWN, stop: 0, hovered: -1, nearest: null, cell: null },
    ...{
      stranger: UNSEEN,
      selected: new Set(),
      highlight: null,
      opening: null,
      mask: new Uint8Array(2 * own.pairs).fill(1),
    },
  }),
  /** A fact about another set changes nothing. */
  learned: (scene, { set, facts }) => (set === scene.set ? { facts: { ...scene.facts, ...facts } } : {}),
  measured: ({ known }, record) => ({ known: { ...known, ...record } }),
  /** A chapter opens: nothing is selected. */
  started: (_, frames) => ({
    selected: new Set(),
    sample: frames.label.findIndex((label, pair) => frames.headless || label === frames.prediction[pair]),
  }),
  replaced: (scene, frames, address) => {
    const { stop = 0, ...more } = moved({ ...scene, frames }, {}, address);
    return { frames, stop, ...more, trail: [3, 2, 1].map((by) => stop - by).filter((at) => at >= 0) };
  },
  moved,
  filtered,
  cellFollowed,
  selected: (_, points) => ({ selected: new Set(points) }),
  lassoSwitched: ({ lasso }) => ({ lasso: !lasso }),
  sensorChosen: ({ alone }, domain) => ({ alone: alone === domain ? -1 : domain }),
};

/** Explore after an event. @template {keyof SceneEvents} Name
 * @param {Scene} scene @param {Name} name @param {SceneEvents[Name]} detail @param {State} address @returns {Scene} */
export const after = (scene, name, detail, address) => ({ ...scene, ...EVENTS[name](scene, detail, address) });

/** p has moved: its stop, the last ones before it, and in the chapter of the order the stops between which it was
 * dragged.
 * @param {Scene} scene @param {unknown} _ @param {State} address @returns {Partial<Scene>} */
function moved({ frames, dragged, stop: before, trail }, _, { p, chapter }) {
  const stop = frames.stop(p);
  const last = stop === before ? trail : [...trail, before].slice(-3);
  const [from, to] = dragged.get(frames) ?? [Infinity, -Infinity];
  if (chapter !== "order" || (from <= stop && stop <= to)) return { stop, trail: last };
  return { stop, trail: last, dragged: new Map(dragged).set(frames, [Math.min(from, stop), Math.max(to, stop)]) };
}

/** Hidden points leave the selection and the pointer. @param {Scene} scene @param {unknown} _ @param {State} address */
function filtered(scene, _, address) {
  const wanted = wantedPoints(scene, address);
  const mask = Uint8Array.from({ length: 2 * scene.frames.pairs }, (_, point) => +wanted(point));
  const selected = new Set([...scene.selected].filter((point) => mask[point]));
  return { mask, selected, hovered: mask[scene.hovered] ? scene.hovered : -1 };
}

/** Return the cell of the confusion matrix in the address, with its pairs; null if there is no such cell.
 * @param {Scene} scene @param {unknown} _ @param {State} address @returns {Partial<Scene>} */
function cellFollowed({ frames, facts }, _, { cell, reading }) {
  const unseen = /** @type {Unseen} */ (facts.unseen);
  const [truth, answer, ...name] = cell.split("~");
  const domain = name.join("~");
  const [is, said] = [unseen.classes[+truth], unseen.classes[+answer]];
  if (!Object.hasOwn(unseen.confusion[reading], domain) || !is || !said) return { cell: null };
  const [source, there] = [unseen.source, domain].map((of) => frames.domains.indexOf(of));
  const pairs = new Set();
  for (let pair = 0; pair < frames.pairs; pair++) {
    const inside = domain === UNSEEN ? frames.domain[pair] !== source : frames.domain[pair] === there;
    const read = unseen.pairs.answers[reading][pair];
    if (inside && unseen.pairs.counts[pair] && frames.label[pair] === +truth && read === +answer) pairs.add(pair);
  }
  return { stranger: domain, cell: { truth: +truth, answer: +answer, pairs, words: `${is} predicted as ${said}` } };
}
