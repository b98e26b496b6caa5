/** The open pair on a small map of F̂, with its tree, at the p of the slider: as the head of the chapters reads it. */

import { Cloud } from "../shared/cloud.js";
import { shownBy } from "../shared/filters.js";
import { nearest, orderText } from "../shared/frames.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames } from "../shared/marks.js";
import { guessesOf, pairMarks, placesAt, withMarks } from "../shared/pair-marks.js";
import { listen } from "../shared/pointer.js";
import { OUTPUT } from "../shared/stages.js";
import { change, state, watch, watchIn } from "../shared/store.js";

const GLIDE = 140; // milliseconds from one stop to the next
const TRAIL = 3; // stops

/** Returns what shows a pair's journey; before it is there, null. @param {HTMLElement} panel @param {Frames} frames */
export function pairMap(panel, frames) {
  const [box, note] = /** @type {NodeListOf<HTMLElement>} */ (panel.querySelectorAll(".still, .where-note"));
  /** @type {Journey | null} */
  let journey = null;
  /** @type {number[]} */
  let trail = []; // stops of the journey, the last one shown
  const cloud = new Cloud(box, 2 * frames.pairs);
  const kind = () => (frames.kinds(OUTPUT).includes(state.map) ? state.map : frames.kinds(OUTPUT)[0]);
  const shown = shownBy(frames);
  listen(cloud, {
    wanted: shown,
    pick: (/** @type {number} */ point) => {
      const pin = point % frames.pairs;
      if (point >= 0) change({ pin, vis: `row:${pin}`, tac: `row:${pin}` });
    },
  });
  cloud.painters = [
    axes(() => axisNames(kind())),
    (context) =>
      pairMarks(context, cloud, {
        journey,
        before: journey
          ? trail.slice(0, -1).map((at) => placesAt(/** @type {Journey} */ (journey), kind(), at).places)
          : [],
      }),
  ];

  function draw() {
    const p = state.p ?? frames.meta.head?.learned_order ?? 0.5;
    const at = journey ? nearest(journey.orders, p) : -1;
    const stop = journey ? frames.stop(journey.orders[at]) : frames.stop(p);
    if (at !== trail.at(-1)) trail = [...trail, at].slice(-TRAIL - 1);
    cloud.layers = layersOf(frames, stop, shown, () => false, 0.34);
    const frame = frames.positions(kind(), OUTPUT, stop);
    if (!frame) return;
    cloud.glide(journey ? withMarks(frame, placesAt(journey, kind(), at)) : frame, GLIDE);
    box.dataset.order = String(frames.orders[stop]);
    if (!journey) return;
    if (!journey.maps[kind()]) {
      note.textContent = `A page without a server places pairs on the PCA map alone.`;
      return;
    }
    const far = Object.values(guessesOf(journey)).some(Boolean);
    const how = journey.maps[kind()]?.exact ? "exact" : "estimated between the nearest neighbours";
    const guessed = far ? "; dashed marks are guesses, because the image is unlike all training images" : "";
    note.textContent =
      `Pale: all pairs at p = ${orderText(frames.orders[stop])}. Stars: the nodes of the tree. Positions are ` +
      `${how}${guessed}. Click a point to choose its pair.`;
  }
  watch(["colour", "map"], draw);
  watchIn("pair", ["p"], draw);
  frames.arrivals.add(draw);
  draw(); // a canvas without a drawing is black

  /** @param {Journey | null} next @param {string} [problem] */
  return (next, problem = "") => {
    journey = next;
    trail = [];
    note.textContent = problem;
    draw();
  };
}
