/** The default pair: one that the head was not trained on and predicts without guessing, if there is one. */

import { json } from "./api.js";
import { classOf, domainOf } from "./frames.js";
import { change, state } from "./store.js";

/** @param {Example[]} examples @param {Frames | null} frames */
export async function somePair(examples, frames) {
  if (state.vis || state.tac) return;
  const { ref } = await json("first").catch(() => ({ ref: null }));
  const chosen = ref ?? shelf(examples, frames)[0]?.ref;
  if (chosen && !state.vis && !state.tac) change({ vis: chosen, tac: chosen });
}

/** Return the gallery: the examples in the set's order of domains and classes, or one pair of the set for each of
 * these.
 * @param {Example[]} examples @param {Frames | null} frames
 * @returns {{ref: Ref, domain: string, truth: string, path?: string, pair?: number}[]} */
export function shelf(examples, frames) {
  if (examples.length || !frames) {
    /** @param {string[] | undefined} names @param {string} name */
    const rank = (names, name) => (names?.includes(name) ? names.indexOf(name) : 1000);
    /** @param {Example} example */
    const place = (example) => 2000 * rank(frames?.domains, example.domain) + rank(frames?.classes, example.class);
    return [...examples]
      .sort((a, b) => place(a) - place(b))
      .map(({ name, domain, class: truth }) => ({ ref: `example:${name}`, domain, truth, path: name }));
  }
  const first = new Map();
  for (let pair = 0; pair < frames.pairs; pair++) {
    const [domain, truth] = [domainOf(frames, pair), classOf(frames, pair)];
    const key = `${domain} ${truth}`;
    if (!first.has(key)) first.set(key, { ref: `row:${pair}`, domain, truth, pair });
  }
  return [...first.values()];
}
