/** The set's frames and thumbnails, fetched once for all tabs. */

import { fetchFrames, fetchThumbnails } from "./frames.js";

let fetching = null;

/** Frames as soon as there are any, and the sprite; either is null where there is none. */
export function theSet() {
  fetching ??= Promise.all([fetchFrames(() => {}), fetchThumbnails()])
    .then(([{ frames }, sprite]) => ({ frames, sprite }))
    .catch(() => {
      fetching = null;
      return { frames: null, sprite: null };
    });
  return fetching;
}
