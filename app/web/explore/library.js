/** The sets that the chapters show: frames, pictures, modes of p, facts. Each is fetched once. */

import { once } from "../shared/api.js";
import { centred, choices, framesOf, unpacked } from "../shared/facts.js";
import { boxes } from "../shared/frames.js";
import { theSet } from "../shared/theset.js";

/** {set, own, sprite, coarse, modes, frames, facts}: what is shown of a set. */
export const dataOf = (set, onWait) =>
  once(`data ${set}`, async () => {
    const [{ frames: own, coarse, sprite }, { modes }] = await Promise.all([theSet(onWait, set), choices(set)]);
    own.coarse = coarse;
    const frames = new Map([["moved", own]]);
    return { set, own, sprite, coarse, modes, frames, facts: { unseen: null, pairs: null, fit: null } };
  });

/** The frames of a mode of p. */
export async function modeFrames(data, mode) {
  if (!data.frames.has(mode)) data.frames.set(mode, await framesOf(mode, data.own, data.set));
  return data.frames.get(mode);
}

/** Frames whose stops are what is known of each domain: nothing, then its mean. Predictions stay the head's. */
export async function centredFrames(data) {
  if (data.centred) return data.centred;
  const kinds = /** @type {("umap" | "pca")[]} */ (["umap", "pca"]);
  const maps = await Promise.all(kinds.map((kind) => centred[kind](data.set)));
  const frames = Object.create(data.own);
  const at = data.own.stop(Number.isFinite(data.own.learned) ? data.own.learned : 0.5) * data.own.pairs;
  const twice = (all) => Uint8Array.from([0, 1].flatMap(() => [...all.subarray(at, at + data.own.pairs)]));
  const { pairs } = data.own;
  const known = maps.map(({ points, ...map }, i) => {
    const touches = unpacked(points);
    const all = new Uint16Array(2 * touches.length); // of each stop, the photos' half stays empty
    for (const stop of [0, 1])
      all.set(touches.subarray(2 * stop * pairs, 2 * (stop + 1) * pairs), (4 * stop + 2) * pairs);
    return [kinds[i], { ...map, all, extents: boxes(all, pairs) }];
  });
  const byKind = Object.fromEntries(known);
  return (data.centred = Object.assign(frames, {
    orders: [0, 1],
    kindOfStops: "centred",
    touchOnly: true,
    prediction: twice(data.own.prediction),
    confidence: twice(data.own.confidence),
    meta: { ...data.own.meta, curves: maps[0].curves },
    kinds: () => kinds,
    positions: (kind, _, stop) => {
      const { all, ...map } = byKind[kind];
      const size = 4 * data.own.pairs;
      return {
        ...map,
        trust: map.trust[stop],
        points: all.subarray(stop * size, (stop + 1) * size),
        drawn: stop,
        stops: 2,
      };
    },
  }));
}
