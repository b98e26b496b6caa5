/** Sources of predictions in a view: the head, comparison heads, simple methods. */

import { ask, json, once } from "./api.js";
import { fetchFrames, whenFine } from "./frames.js";
import { TABLES } from "./tables.js";

const METHOD = "method:";
const finest = new Map(); // head -> its finer frames, once they are there

/** The server's heads: [{name, folder, generation, source, …}], the first one first. */
export const heads = () => once("heads", () => json("heads"));

export const headLabel = (one) =>
  `${one.name || one.folder}${one.problem ? "" : ` · ${one.source} · ${one.mffa ? one.generation : "no MFFA"}`}`;
/** The methods that can be fitted: on the pairs of the head's source, by their classes. */
export const methodsFor = ({ source, domains, labelled }) =>
  labelled !== false && domains.includes(source)
    ? TABLES.methods.map(({ id, title }) => [`${METHOD}${id}`, title])
    : [];
export const isMethod = (name) => name.startsWith(METHOD);

/** The frames of `name`; "" is the first head, whose frames are loaded.
 * If coarse frames come first, `onFiner` is called once finer ones exist. */
export function framesBy(name, own, onWait, onFiner = () => {}) {
  if (!name) return Promise.resolve(own);
  if (finest.has(name)) return Promise.resolve(finest.get(name));
  return once(`by ${name}`, () => (isMethod(name) ? byMethod(name, own) : fetched(name, onWait, onFiner)));
}

async function fetched(name, onWait, onFiner) {
  const { frames, coarse } = await fetchFrames(onWait, { head: name });
  frames.by = `the head ${name}`;
  if (coarse) {
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

/** The same maps with the predictions of a method, which do not depend on p. */
async function byMethod(name, own) {
  const found = await ask("predictions", { method: name.slice(METHOD.length) });
  const index = found.classes.map((label) => own.classes.indexOf(label));
  const frames = Object.create(own);
  const repeat = (values) => {
    const all = new Uint8Array(own.orders.length * own.pairs);
    own.orders.forEach((_, stop) => all.set(values, stop * own.pairs));
    return all;
  };
  const predicted = found.prediction.map((k) => index[k]);
  Object.assign(frames, { by: found.label, still: true });
  frames.prediction = repeat(predicted);
  frames.confidence = repeat(found.confidence);
  const curves = Object.fromEntries(
    Object.entries(own.meta.curves).filter(([key]) => !/^(accuracy|macro_f1)/.test(key)),
  );
  for (const [name, value] of Object.entries(found.accuracy)) {
    curves[`accuracy/${name}`] = own.orders.map(() => value);
  }
  frames.meta = { ...own.meta, curves };
  return frames;
}
