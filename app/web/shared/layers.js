/** Layers of points: one for each colour and shape, dimmed ones first. */

import { colouring } from "./palette.js";
import { state } from "./store.js";

const DIM = 0.13;
const LIT = 0.68;

/**
 * shown(point) and lit(point) select the points that are drawn, and those in full colour.
 * dim is the opacity of the others.
 * Returns [{style, at, count}], lit ones last.
 */
export function layersOf(frames, stop, shown, lit, dim = DIM, colour = state.colour) {
  const chosen = colouring(frames, colour);
  const groups = chosen.groups(frames);
  const of = chosen.of(frames, stop);
  const total = 2 * frames.pairs;
  const radius = total > 12_000 ? 1.5 : total > 5_000 ? 1.9 : 2.4;
  const layers = [];
  for (const alpha of [dim, LIT]) {
    for (const tac of [0, 1]) {
      for (const [, colour] of groups) {
        const style = { shape: tac ? "triangle" : "circle", colour, radius, alpha };
        layers.push({ style, at: new Int32Array(frames.pairs), count: 0 });
      }
    }
  }
  const bright = layers.length / 2;
  for (let tac = 0; tac < 2; tac++) {
    for (let pair = 0; pair < frames.pairs; pair++) {
      const point = pair + tac * frames.pairs;
      if (!shown(point)) continue;
      const layer = layers[(lit(point) ? bright : 0) + tac * groups.length + of(pair, tac)];
      layer.at[layer.count++] = point;
    }
  }
  return layers.filter((layer) => layer.count);
}
