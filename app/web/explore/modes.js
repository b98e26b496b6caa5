/** Modes of p: a head for each stop, one head with fixed weights, or one head for every p. */

import { refused } from "../shared/api.js";
import { framesOf } from "../shared/facts.js";
import { orderText } from "../shared/frames.js";
import { ACCURACY, values } from "../shared/measures.js";
import { mean } from "../shared/numbers.js";
import { OUTPUT } from "../shared/stages.js";
import { has, modeOf, OWN_MODE, sensorOf, worded } from "../shared/tables.js";
import { $, choice, html, joined, percent, scene, send, state } from "./root.js";

/** @type {(head: NonNullable<FramesMeta["head"]>) => string} */
const trainings = ({ seeds = [], width }) =>
  joined([seeds.length > 1 && `${seeds.length} trainings for each stop`, width && `width ${width}`]);

const SIGNALS = " Each pair consists of two recordings of one signal: “photo” is the first, “touch” the second.";

/** Return an explanation of the chosen mode, and of a set of signals. @param {Frames} frames */
export function modeWords(frames) {
  const { learned, meta, source } = frames;
  const more = trainings(meta.head ?? {});
  const { lead, words = "" } = modeOf(frames);
  const sentence = worded(words, {
    source: sensorOf(source),
    trainings: more && ` (${more})`,
    band: (meta.head?.seeds?.length ?? 0) > 1 ? "; the pale band spans all trainings" : "",
    learned: Number.isFinite(learned) ? orderText(+learned.toFixed(3)) : "its own p",
    elsewhere: has(frames, "what-if") ? elsewhere(frames) : "",
  });
  return html`${lead && html`<b>${lead}</b>`}${sentence}${frames.signals && SIGNALS}`;
}

/** Return the accuracy at the orders that the head was not trained for, in words; "" if not measured.
 * @param {Frames} frames */
function elsewhere(frames) {
  const [low, high] = frames.fits ?? [NaN, NaN];
  /** @type {number[] | null} */
  const curve = values(frames, ACCURACY, OUTPUT);
  const own = curve?.filter((v, i) => Number.isFinite(v) && !(low <= frames.orders[i] && frames.orders[i] <= high));
  if (!own?.length) return "";
  const chance = percent(1 / frames.classes.length);
  return `Outside the band, its mean accuracy in unseen domains is ${percent(mean(own))} (chance: ${chance}). `;
}

/** Return the mode that is wanted: the one in the address, or the first of the set. */
const wantedMode = () => (scene.modes.includes(state.mode) ? state.mode : scene.modes[0]);

/** Show the choice between the modes of a set. */
function showModes() {
  const { modes, own } = scene;
  const options = modes.map((key) => {
    // the loaded head may be one for every p
    const { title = "", help } = modeOf({ kind: key === OWN_MODE ? own.kind : key });
    return { key, label: title, title: help };
  });
  $(".modes").hidden = modes.length < 2;
  choice(".modes", "mode", options, scene.mode);
}

/** Return the frames of a mode; null if they cannot be had or others are wanted by then. `say` shows the sentence of a
 * Refusal.
 * @param {(sentence: string) => void} say @returns {Promise<Frames | null>} */
export async function framesOfMode(say, wanted = wantedMode()) {
  const { own, set } = send("arrived", { wanted });
  try {
    const frames = wanted === OWN_MODE ? own : await framesOf(wanted, own, set);
    if (scene.wanted !== wanted || scene.set !== set) return null;
    send("arrived", { mode: wanted });
    showModes();
    return frames;
  } catch (error) {
    refused(error, say);
    return wanted === OWN_MODE ? null : framesOfMode(say, OWN_MODE);
  }
}

/** Return whether another mode is wanted than the one that is shown or on its way. */
export const isOtherWanted = () => wantedMode() !== scene.wanted;
