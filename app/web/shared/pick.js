/** The default pair: one that the head was not trained on and predicts without guessing, if there is one. */

import { json } from "./api.js";
import { change, state } from "./store.js";

export async function somePair(examples, frames) {
  if (state.vis || state.tac) return;
  const { ref } = await json("first").catch(() => ({ ref: null }));
  const any = examples.length ? `example:${inOrder(examples, frames)[0].name}` : frames ? "row:0" : null;
  const chosen = ref ?? any;
  if (chosen && !state.vis && !state.tac) change({ vis: chosen, tac: chosen });
}

/** Examples in the set's order of domains and classes. */
function inOrder(examples, frames) {
  const rank = (names, name) => (names?.includes(name) ? names.indexOf(name) : 1000);
  return [...examples].sort(
    (a, b) =>
      rank(frames?.domains, a.domain) - rank(frames?.domains, b.domain) ||
      rank(frames?.classes, a.class) - rank(frames?.classes, b.class),
  );
}

/** The gallery: the examples, or one pair of the set for each domain and class. */
export function shelf(examples, frames) {
  if (examples.length || !frames) {
    return inOrder(examples, frames).map((one) => ({
      ref: `example:${one.name}`,
      domain: one.domain,
      truth: one.class,
      path: one.name,
    }));
  }
  const seen = new Set();
  const found = [];
  for (let pair = 0; pair < frames.pairs; pair++) {
    const key = frames.domain[pair] * 1000 + frames.label[pair];
    if (seen.has(key)) continue;
    seen.add(key);
    found.push({
      ref: `row:${pair}`,
      domain: frames.domains[frames.domain[pair]],
      truth: frames.classes[frames.label[pair]],
      pair,
    });
  }
  return found;
}
