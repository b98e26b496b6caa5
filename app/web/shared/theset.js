/** The set's frames and thumbnails, fetched once for all tabs. */

import { json } from "./api.js";
import { fetchFrames, fetchThumbnails } from "./frames.js";
import { isSimulated } from "./text.js";

let fetching = null;
const waiting = new Set();

/** {frames, coarse, sprite}; `onWait` gets the server's progress. Throws a Refusal.
 * @param {(step: any) => void} onWait */
export function theSet(onWait = () => {}) {
  waiting.add(onWait);
  fetching ??= fetchAll().catch((error) => {
    fetching = null; // the next call tries again
    throw error;
  });
  return fetching;
}

const NO_SET = { frames: null, sprite: null };

/** The set. While the server computes its map: nulls, and a promise of the set as `later`.
 * Without a map that promise stays pending; Explore shows the reason. */
export function theSetSoon() {
  return new Promise((resolve) => {
    const coming = theSet(() => resolve({ ...NO_SET, later }));
    const later = new Promise((there) => {
      coming.then(there, () => {});
    });
    coming.then(resolve, () => resolve({ ...NO_SET, later }));
  });
}

async function fetchAll() {
  let told = false; // the badge does not wait for the map
  const tell = (step) => {
    if (!told)
      json("about")
        .then(({ embeddings: own }) => sayWhetherSimulated(own.simulated, own.domains ?? []))
        .catch(() => {});
    told = true;
    waiting.forEach((one) => one(step));
  };
  const { frames, coarse, drawn } = await fetchFrames(tell);
  const sprite = drawn ? await fetchThumbnails() : null;
  sayWhetherSimulated(frames.meta.embeddings.simulated, frames.domains);
  return { frames, coarse, sprite };
}

function sayWhetherSimulated(stated, domains) {
  const detail = stated || domains.some(isSimulated);
  document.dispatchEvent(new CustomEvent("omnivat:simulated", { detail }));
}
