/** Facts about the set and its heads; each is fetched once. */

import { inSet, json, once, Refusal } from "./api.js";
import { classOf, fetchFrames } from "./frames.js";
import { OWN_MODE } from "./tables.js";
import { bytesOf } from "./text.js";

/** A fact about a set; "" is the page's own. @template {keyof Replies} Name @param {Name} name */
const fact =
  (name) =>
  (set = "") =>
    once(`${name} ${set}`, () => json(inSet(name, set)));

const KINDS = { u1: Uint8Array, u2: Uint16Array, i2: Int16Array };

/** Unpack numbers from the server: integers in steps. @param {Packed} packed @returns {Numbers} */
function unpacked({ kind, steps, data }) {
  const whole = new KINDS[kind](bytesOf(data).buffer);
  return steps === 1 ? whole : Float64Array.from(whole, (n) => n / steps);
}

/** @template {string} Name @param {Record<Name, Packed>} all */
const each = (all) =>
  /** @type {Record<Name, Numbers>} */ (
    Object.fromEntries(Object.entries(all).map(([name, packed]) => [name, unpacked(/** @type {Packed} */ (packed))]))
  );

/** Fetch the accuracy in unseen domains; values of each pair are typed arrays. @returns {Promise<Unseen>} */
export const unseen = (set = "") =>
  once(`unseen ${set}`, async () => {
    const found = await json(inSet("unseen", set));
    const { answers, ...pairs } = found.pairs;
    return { ...found, pairs: { ...each(pairs), answers: each(answers) } };
  });
/** What is loaded: head and embeddings with their origin, limits, a sensor’s profile. */
export const loaded = fact("about");
/** Why the head does not fit the set, and what to do; "" if it fits. */
export const fit = fact("fit");
/** Names of the pairs, and the classes they imitate. */
export const pairNames = fact("pairs");
/** The mechanism on a toy. */
export const toyFacts = fact("toy");
/** What heads predict of the twins: one press of one object, by every sensor and in every scene. */
export const twins = fact("twins");
/** Positions of the twins' touches: as they come, mean moved, mean and spread moved. */
export const twinsMap = fact("twins/map");
/** What is known of a new sensor, and the accuracy that it brings. */
export const ladder = fact("ladder");
/** Modes of p and sets; only the head if the server lists none. @returns {Promise<Choices>} */
export const choices = (set = "") =>
  once(`modes ${set}`, () => json(inSet("modes", set))).catch(() => ({ modes: [OWN_MODE], sets: [], twins: false }));

/** Return frames of another mode than the head's; `own` are the head's frames, of the same pairs.
 * @param {string} mode @param {Frames} own */
export const framesOf = (mode, own, set = "") =>
  once(`frames ${mode} ${set}`, async () => {
    const { frames } = await fetchFrames(() => {}, { mode, set });
    if (frames.pairs !== own.pairs || frames.label.some((_, pair) => classOf(frames, pair) !== classOf(own, pair)))
      throw new Refusal("The frames of this mode belong to other pairs; make them again with `omnivat sweep`.");
    frames.foreign = true;
    return frames;
  });
