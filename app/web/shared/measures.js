/** The measures in the frames: gaps, margin and accuracy of each stage at every stop. */

import { featuresOf } from "./stages.js";
import { can, TABLES } from "./tables.js";

/** The measures that are named in brief: a share of predictions, and gaps. */
const BRIEF = TABLES.measures.filter((row) => can(row, "brief"));
export const GAPS = BRIEF.filter((row) => !can(row, "predictions"));
export const ACCURACY = TABLES.measures.find((row) => can(row, "predictions"))?.id ?? "";

/** Return the gaps and margins that frames have of some step: all measures of features. @param {Frames} frames */
export const gapsOf = (frames) => {
  const names = new Set(Object.keys(frames.meta.curves).map((key) => key.split("/")[0]));
  return TABLES.measures.filter(({ id }) => id !== ACCURACY && names.has(id));
};

/** @param {Frames} frames @param {string} name @returns {number[] | null} */
const series = (frames, name) => frames.meta.curves[name] ?? null;
/** @param {Frames} frames @param {string} domain */
const isSource = (frames, domain) => domain !== "" && domain === frames.meta.head?.source;

/** Return the name of an accuracy curve over several trainings, without its suffix.
 * @param {Frames} frames @param {string} domain */
const trainedAccuracy = (frames, domain) =>
  `seeds:${ACCURACY}/${isSource(frames, domain) ? "source_test" : domain || "unseen"}`;

/** Return accuracy per stop, the mean if there are several trainings. Training pairs are excluded; a single training
 * therefore has no accuracy in its source domain.
 * @param {Frames} frames @param {string} domain */
const accuracy = (frames, domain) =>
  series(frames, `${trainedAccuracy(frames, domain)}/mean`) ??
  (isSource(frames, domain) ? null : series(frames, `${ACCURACY}/${domain || "unseen"}`));

/** Return the values of one measure at one stage, of one domain if named; null if not measured.
 * @param {Frames} frames @param {string} name @param {string} stage */
export function values(frames, name, stage, domain = "") {
  if (name === ACCURACY) return accuracy(frames, domain);
  return series(frames, `${name}/${featuresOf(stage)}${domain && `/${domain}`}`);
}

/** Return minimum and maximum over trainings: {low, high}, or null for a single training.
 * @param {Frames} frames @param {string} name @param {string} stage */
export function spread(frames, name, stage, domain = "") {
  if (domain && name !== ACCURACY) return null;
  const stem = name === ACCURACY ? trainedAccuracy(frames, domain) : `seeds:${name}/${featuresOf(stage)}`;
  const [low, high] = ["low", "high"].map((end) => series(frames, `${stem}/${end}`));
  return low && high && { low, high };
}

/** Return one axis for a measure at every stage, domain and stop: a flat line stays flat.
 * @param {Frames} frames @param {string} name @returns {[number, number]} */
export function axis(frames, name) {
  if (name === ACCURACY) return [0, 1];
  const all = Object.entries(frames.meta.curves)
    .filter(([key]) => key.startsWith(`${name}/`))
    .flatMap(([, own]) => own.filter(Number.isFinite));
  const top = Math.max(0.1, ...all);
  const low = Math.min(0, ...all);
  const step = 10 ** Math.floor(Math.log10(top)) / 2;
  return [Math.floor(low / step) * step, Math.ceil(top / step - 1e-9) * step];
}

/** @param {string} name @param {number} [value] */
export const asText = (name, value = NaN, digits = 3) =>
  !Number.isFinite(value) ? "–" : name === ACCURACY ? `${(100 * value).toFixed(1)}\u00a0%` : value.toFixed(digits);
