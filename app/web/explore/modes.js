/** What moving p means: a head for each stop, one head whose p moves, or one head for every p. */

import { refused } from "../shared/api.js";
import { framesOf } from "../shared/facts.js";
import { orderText } from "../shared/frames.js";
import { radios } from "../shared/radios.js";
import { change, state } from "../shared/store.js";
import { escaped } from "../shared/text.js";

const LABELS = {
  trained: ["Trained here", "Each stop is a head that was trained at that p"],
  moved: ["Same weights", "One head; only p moves"],
  every: ["Every p", "One head that was trained for every p"],
};

/** The name that a mode has on the page; frames of the loaded head may be of a head for every p. */
const label = (mode, own) => LABELS[mode === "moved" && own.kind === "every" ? "every" : mode][0];

const trainings = ({ seeds = [], width }) =>
  [seeds.length > 1 && `${seeds.length} trainings a stop`, width && `width ${width}`]
    .filter(Boolean)
    .join(", ");

/** What the chosen mode means, as HTML. */
export function modeWords(frames) {
  if (frames.kind === "retrained") {
    const more = trainings(frames.meta.head);
    return `<b>A head for each stop</b>, trained at that p on ${escaped(frames.source)}${more && ` (${more})`}. Dots are stops${frames.meta.head.seeds?.length > 1 ? "; the pale band is from the lowest to the highest training" : ""}.`;
  }
  if (frames.kind === "every")
    return `<b>One head for every p</b>: p was drawn at random in each training step.`;
  const learned = Number.isFinite(frames.learned) ? orderText(+frames.learned.toFixed(3)) : "its own p";
  return `<b>What if only p moved?</b> The weights stay those learned at p = ${learned}. Shaded: the orders this head was trained for. Elsewhere it is near guessing, and a small gap means little.`;
}

/** The mode to open with: that of the address, or the first that there is. */
export const openingMode = (modes) => (modes.includes(state.mode) ? state.mode : modes[0]);

export class Modes {
  /** `onFrames(frames)` shows the frames of a mode; `say` takes the sentence of a refusal. */
  constructor($, scene, modes, { onFrames, say }) {
    this.$ = $;
    this.scene = scene;
    this.modes = modes;
    this.onFrames = onFrames;
    this.say = say;
    this.kept = new Map([["moved", scene.own]]);
    this.mode = "moved";
    const box = $(".modes");
    box.hidden = modes.length < 2;
    const options = modes.map((key) => ({ key, label: label(key, scene.own), title: LABELS[key][1] }));
    this.showChosen = radios(
      box,
      options,
      () => this.mode,
      (key) => this.choose(key),
    );
  }

  /** Show the frames of a mode, fetched when it is first chosen. */
  async choose(mode) {
    this.wanted = mode;
    try {
      if (!this.kept.has(mode)) this.kept.set(mode, await framesOf(mode, this.scene.own));
    } catch (error) {
      return refused(error, this.say);
    }
    if (this.wanted !== mode) return;
    this.mode = mode;
    change({ mode: mode === this.modes[0] ? "" : mode });
    this.showChosen();
    this.onFrames(this.kept.get(mode));
  }

  /** Show the mode that the address names, where another one is shown. */
  follow() {
    const wanted = openingMode(this.modes);
    if (wanted !== this.wanted) this.choose(wanted);
  }

  /** Finer frames of the head itself have come. */
  replace(own) {
    this.kept.set("moved", own);
    return this.kept.get(this.mode);
  }
}
