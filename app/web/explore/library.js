/** The sets that the chapters show: frames, pictures, modes of p, facts. Each is fetched once. */

import { once } from "../shared/api.js";
import { choices, framesOf } from "../shared/facts.js";
import { OWN_MODE } from "../shared/tables.js";
import { theSet } from "../shared/theset.js";

/** {set, own, sprite, coarse, modes, frames, facts}: what is shown of a set. */
export const dataOf = (set, onWait) =>
  once(`data ${set}`, async () => {
    const [{ frames: own, coarse, sprite }, { modes }] = await Promise.all([theSet(onWait, set), choices(set)]);
    own.coarse = coarse;
    const frames = new Map([[OWN_MODE, own]]);
    return { set, own, sprite, coarse, modes, frames, facts: { unseen: null, pairs: null, fit: null } };
  });

/** The frames of a mode of p. */
export async function modeFrames(data, mode) {
  if (!data.frames.has(mode)) data.frames.set(mode, await framesOf(mode, data.own, data.set));
  return data.frames.get(mode);
}
