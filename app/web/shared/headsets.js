/** Sources of predictions in a view: the head, comparison heads, simple methods. */

import { ask, json, once } from "./api.js";
import { fetchFrames, whenFine } from "./frames.js";
import { sensorOf, TABLES } from "./tables.js";

const METHOD = "method:";
/** @type {Map<string, Frames>} */
const finest = new Map(); // head -> its finer frames, once they are there

/** Return the server's heads, the first one first. */
export const heads = () => once("heads", () => json("heads"));

/** @param {HeadRow} head */
export const headLabel = ({ name, folder, problem, source, mffa, generation }) =>
  `${name || folder}${problem ? "" : ` · ${sensorOf(source ?? "")} · ${mffa ? generation : "no MFFA"}`}`;
/** Return the methods that can be fitted: on the pairs of the head's source, by their classes.
 * @param {Frames} frames @returns {[value: string, label: string][]} */
export const methodsFor = ({ source, domains, labelled }) =>
  labelled && domains.includes(source) ? TABLES.methods.map(({ id, title }) => [`${METHOD}${id}`, title]) : [];
/** @param {string} name */
export const isMethod = (name) => name.startsWith(METHOD);

/** Return the frames of `name`; "" is the first head, whose frames are loaded. If coarse frames come first, `onFiner`
 * is called once finer ones exist.
 * @param {string} name @param {Frames} own @param {(step: Step | null) => void} onWait @param {() => void} onFiner
 * @returns {Promise<Frames>} */
export function framesBy(name, own, onWait, onFiner) {
  const loaded = name ? finest.get(name) : own;
  if (loaded) return Promise.resolve(loaded);
  return once(`by ${name}`, () => (isMethod(name) ? byMethod(name, own) : fetched(name, onWait, onFiner)));
}

/** Fetch the frames of another head; `onFiner` is called once finer ones have come.
 * @param {string} name @param {(step: Step | null) => void} onWait @param {() => void} onFiner */
async function fetched(name, onWait, onFiner) {
  const { frames } = await fetchFrames(onWait, { head: name });
  frames.by = `the head ${name}`;
  if (frames.coarse) {
    whenFine(() => {}, { head: name }).then(
      (finer) => {
        finest.set(name, finer);
        onFiner();
      },
      () => {},
    ); // keep the current display
  }
  return frames;
}

/** Return the same maps with the predictions of a method, which do not depend on p.
 * @param {string} name @param {Frames} own @returns {Promise<Frames>} */
async function byMethod(name, own) {
  const { label, classes, prediction, confidence, accuracy } = await ask("predictions", {
    method: name.slice(METHOD.length),
  });
  const index = classes.map((label) => own.classes.indexOf(label));
  /** @param {number[]} values */
  const repeated = (values) => {
    const all = new Uint8Array(own.orders.length * own.pairs);
    for (let at = 0; at < all.length; at += own.pairs) all.set(values, at);
    return all;
  };
  const steps = new Set(TABLES.stages.map(({ id }) => id)); // curves of features name theirs, those of predictions none
  const curves = Object.entries(own.meta.curves).filter(([key]) => steps.has(key.split("/")[1]));
  const flat = Object.entries(accuracy).map(([key, share]) => [`accuracy/${key}`, own.orders.map(() => share)]);
  return Object.assign(Object.create(own), {
    by: label,
    still: true,
    prediction: repeated(prediction.map((k) => index[k])),
    confidence: repeated(confidence),
    meta: { ...own.meta, curves: Object.fromEntries([...curves, ...flat]) },
  });
}
