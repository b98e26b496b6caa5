/** Modes of p: a head for each stop, one head with fixed weights, or one head for every p. */

import { refused } from "../shared/api.js";
import { orderText } from "../shared/frames.js";
import { values } from "../shared/measures.js";
import { radios } from "../shared/radios.js";
import { change, state } from "../shared/store.js";
import { has, modeOf, OWN_MODE, worded } from "../shared/tables.js";
import { escaped, percent } from "../shared/text.js";
import { modeFrames } from "./library.js";

/** A mode's row on the page; the loaded head may be a head for every p. */
const rowOf = (mode, own) => modeOf({ kind: mode === OWN_MODE ? own.kind : mode });

const trainings = ({ seeds = [], width }) =>
  [seeds.length > 1 && `${seeds.length} trainings for each stop`, width && `width ${width}`].filter(Boolean).join(", ");

const SIGNALS = " Each pair is two recordings of one signal: “photo” stands for the first, “touch” for the second.";

/** An explanation of the chosen mode, and of a set of signals, as HTML. */
export const modeWords = (frames) => ofMode(frames) + (frames.signals ? SIGNALS : "");

function ofMode(frames) {
  const { learned, meta, source } = frames;
  const more = trainings(meta.head ?? {});
  return worded(modeOf(frames).words ?? "", {
    source: escaped(source),
    trainings: more && ` (${more})`,
    band: meta.head?.seeds?.length > 1 ? "; the pale band is from the lowest to the highest training" : "",
    learned: Number.isFinite(learned) ? orderText(+learned.toFixed(3)) : "its own p",
    elsewhere: has(frames, "what-if") ? elsewhere(frames) : "",
  });
}

/** The accuracy at the orders that the head was not trained for, in words; "" if not measured. */
function elsewhere(frames) {
  const near = frames.fits;
  const own = values(frames, "accuracy", "f_hat")?.filter(
    (v, i) => Number.isFinite(v) && !(near?.[0] <= frames.orders[i] && frames.orders[i] <= near?.[1]),
  );
  if (!own?.length) return "";
  const mean = own.reduce((sum, v) => sum + v, 0) / own.length;
  return `Elsewhere its mean accuracy in unseen domains is ${percent(mean)} (guessing: ${percent(1 / frames.classes.length)}). `;
}

export class Modes {
  /** `onFrames(frames)` shows the frames of a mode; `say` shows the sentence of a Refusal. */
  constructor(box, { onFrames, say }) {
    this.box = box;
    this.onFrames = onFrames;
    this.say = say;
    this.mode = ""; // the one shown
    this.wanted = "";
    /** @type {any} */
    this.data = null;
    this.showChosen = () => {};
  }

  /** The frames that a set opens with: of the mode in the address, or of the first one. */
  async open(data) {
    this.data = data;
    this.box.hidden = data.modes.length < 2;
    const options = data.modes.map((key) => {
      const { title, help } = rowOf(key, data.own);
      return { key, label: title, title: help };
    });
    this.showChosen = radios(
      this.box,
      options,
      () => this.mode,
      (key) => this.choose(key),
    );
    return this.fetched(this.opening());
  }

  opening() {
    const { modes } = this.data;
    return modes.includes(state.mode) ? state.mode : modes[0];
  }

  /** The frames of a mode; null if they cannot be had or another mode is wanted by then. */
  async fetched(mode) {
    const { data } = this;
    this.wanted = mode;
    try {
      const frames = await modeFrames(data, mode);
      if (this.wanted !== mode || this.data !== data) return null;
      this.mode = mode;
      this.showChosen();
      return frames;
    } catch (error) {
      refused(error, this.say);
      return mode === OWN_MODE ? null : this.fetched(OWN_MODE);
    }
  }

  async choose(mode) {
    const frames = await this.fetched(mode);
    if (!frames) return;
    change({ mode: mode === this.data.modes[0] ? "" : mode });
    this.onFrames(frames);
  }

  /** Show the mode in the address if another one is shown. */
  follow() {
    if (this.opening() !== this.wanted) this.choose(this.opening());
  }
}
