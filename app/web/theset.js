/** The set's frames and thumbnails, fetched once for all tabs. */

import { fetchFrames, fetchThumbnails } from "./frames.js";
import { isSimulated } from "./text.js";

let fetching = null;
const waiting = new Set();

/** {frames, coarse, sprite}; `onWait` hears how far the server is. Fails with a sentence. */
export function theSet(onWait = () => {}) {
  waiting.add(onWait);
  fetching ??= fetchAll().catch((error) => {
    fetching = null; // the next who asks tries again
    throw error;
  });
  return fetching;
}

async function fetchAll() {
  const tell = (step) => waiting.forEach((told) => told(step));
  const [{ frames, coarse }, sprite] = await Promise.all([fetchFrames(tell), fetchThumbnails()]);
  const simulated = frames.meta.embeddings.simulated || frames.domains.some(isSimulated);
  document.dispatchEvent(new CustomEvent("omnivat:simulated", { detail: simulated }));
  return { frames, coarse, sprite };
}
