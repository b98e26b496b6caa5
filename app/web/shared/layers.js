/** Layers of points: one for each colour and shape, dimmed ones first. */

import { colouring } from "./palette.js";
import { state } from "./store.js";

const DIM = 0.13;
const LIT = 0.68;

/**
 * shown(point) and lit(point) select the points that are drawn, and those in full colour.
 * dim is the opacity of the others.
 * Returns [{style, at, count}], lit ones last.
 * @param {Colourable} frames @param {number} stop @param {(point: number) => boolean} shown
 * @param {(point: number) => boolean} lit @returns {Layer[]}
 */
export function layersOf(frames, stop, shown, lit, dim = DIM) {
  const chosen = colouring(frames, state.colour);
  const groups = chosen.groups(frames);
  const of = chosen.of(frames, stop);
  const total = 2 * frames.pairs;
  const radius = total > 12_000 ? 1.5 : total > 5_000 ? 1.9 : 2.4;
  /** @type {Layer[]} */
  const layers = [dim, LIT].flatMap((alpha) =>
    /** @type {const} */ (["circle", "triangle"]).flatMap((shape) =>
      groups.map(([, colour]) => ({
        style: { shape, colour, radius, alpha },
        at: new Int32Array(frames.pairs),
        count: 0,
      })),
    ),
  );
  const bright = layers.length / 2;
  for (let point = 0; point < total; point++) {
    if (!shown(point)) continue;
    const tac = point >= frames.pairs ? 1 : 0;
    const group = of(point - tac * frames.pairs, tac);
    const layer = layers[(lit(point) ? bright : 0) + tac * groups.length + group];
    layer.at[layer.count++] = point;
  }
  return layers.filter((layer) => layer.count);
}
