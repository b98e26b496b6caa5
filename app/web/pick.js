/** The current pair where a visitor has chosen none: the first example, or the set's first pair. */

import { change, state } from "./store.js";

export function somePair(examples, frames) {
  if (state.vis || state.tac) return;
  const ref = examples.length ? `example:${examples[0].name}` : frames ? "row:0" : null;
  if (ref) change({ vis: ref, tac: ref });
}

/** What the gallery offers: the examples, or of the set one pair for each domain and class. */
export function shelf(examples, frames) {
  if (examples.length || !frames) {
    return examples.map((one) => ({ ref: `example:${one.name}`, domain: one.domain, truth: one.class, path: one.name }));
  }
  const seen = new Set();
  const found = [];
  for (let pair = 0; pair < frames.pairs; pair++) {
    const key = frames.domain[pair] * 1000 + frames.label[pair];
    if (seen.has(key)) continue;
    seen.add(key);
    found.push({ ref: `row:${pair}`, domain: frames.domains[frames.domain[pair]], truth: frames.classes[frames.label[pair]], pair });
  }
  return found;
}
