/** What the server knows of the set and its heads, each fetched once for all who need it. */

import { json, Refusal } from "./api.js";
import { fetchFrames } from "./frames.js";

const kept = new Map();

/** The promise called `name`, made once; after a failure the next call tries again. */
function once(name, make) {
  if (!kept.has(name)) {
    const made = make().catch((error) => {
      kept.delete(name);
      throw error;
    });
    kept.set(name, made);
  }
  return kept.get(name);
}

const fact = (name) => () => once(name, () => json(name));

/** How the head does in unseen domains. */
export const unseen = fact("unseen");
/** Names of the pairs, and what they imitate. */
export const pairNames = fact("pairs");
/** The mechanism on a toy. */
export const toyFacts = fact("toy");
/** Modes of p and sets to choose from; the head alone where the server lists none. */
export const choices = () => once("modes", () => json("modes").catch(() => ({ modes: ["moved"], sets: [] })));

/** Frames of a mode other than the head's own; `own` are those, and the pairs have to be the same. */
export const framesOf = (mode, own) =>
  once(`frames ${mode}`, async () => {
    const { frames } = await fetchFrames(() => {}, "", mode);
    const same = (k, pair) => frames.classes[k] === own.classes[own.label[pair]];
    if (frames.pairs !== own.pairs || !frames.label.every(same))
      throw new Refusal("The frames of this mode are of other pairs; make them again with `omnivat sweep`.");
    return frames;
  });
