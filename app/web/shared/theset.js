/** The set's frames and thumbnails, fetched once for all tabs. */

import { once } from "./api.js";
import { loaded } from "./facts.js";
import { fetchFrames, fetchThumbnails } from "./frames.js";
import { line } from "./held.js";
import { isSimulated } from "./text.js";

/** @typedef {(step: Step | null) => void} OnWait */
/** @type {Set<OnWait>} */
const waiting = new Set();

/** {frames, sprite} of a set, "" being the page's own; `onWait` gets the server's progress. Throws a
 * Refusal. @param {OnWait} onWait */
export function theSet(onWait = () => {}, set = "") {
  waiting.add(onWait);
  return once(`set ${set}`, () => fetchAll(set));
}

/** Return the set. While the server computes its map, or the models of a page without a server come first: nulls, and a
 * promise of the set as `later`. Without a map that promise stays pending; Explore shows the reason.
 * @returns {Promise<{frames: Frames | null, sprite: Sprite | null, later?: ReturnType<typeof theSet>}>} */
export function theSetSoon() {
  return new Promise((resolve) => {
    const without = () => resolve({ frames: null, sprite: null, later });
    const coming = theSet(without);
    /** @type {typeof coming} */
    const later = new Promise((there) => {
      coming.then(there, () => {});
    });
    coming.then(resolve, without);
    if (line.models) setTimeout(without); // after a set that is there
  });
}

/** Fetch the frames, thumbnails and facts of a set. @param {string} set */
async function fetchAll(set) {
  /** The badge does not wait for the map. @param {Step | null} step */
  const tell = (step) => {
    loaded(set)
      .then(({ embeddings: own }) => sayWhetherSimulated(own.simulated, own.domains))
      .catch(() => {});
    for (const onWait of waiting) onWait(step);
  };
  const { frames, drawn } = await fetchFrames(tell, { set });
  const sprite = drawn ? await fetchThumbnails(set) : null;
  sayWhetherSimulated(frames.meta.embeddings.simulated, frames.domains);
  return { frames, sprite };
}

/** Name what the data on the screen are. @param {boolean | undefined} stated @param {string[]} domains */
export function sayWhetherSimulated(stated, domains = []) {
  const detail = stated || domains.some(isSimulated);
  document.dispatchEvent(new CustomEvent("omnivat:simulated", { detail }));
}
