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

const KINDS = { u1: Uint8Array, u2: Uint16Array, i2: Int16Array };

/** The numbers that the server packed: whole ones, in steps. */
export function unpacked({ kind, steps, data }) {
  const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  const whole = new KINDS[kind](bytes.buffer);
  return steps === 1 ? whole : Float64Array.from(whole, (n) => n / steps);
}

/** How the head does in unseen domains; what is known of each pair as typed arrays. */
export const unseen = () =>
  once("unseen", async () => {
    const found = await json("unseen");
    const { counts, answers, confidence, cosine } = found.pairs;
    return {
      ...found,
      pairs: {
        counts: unpacked(counts),
        answers: Object.fromEntries(Object.entries(answers).map(([name, own]) => [name, unpacked(own)])),
        confidence: unpacked(confidence),
        cosine: unpacked(cosine),
      },
    };
  });
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
