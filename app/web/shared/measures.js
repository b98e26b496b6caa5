/** The measures in the frames: gaps, margin and accuracy of each stage at every stop. */

import { featuresOf } from "./stages.js";

export const MEASURES = [
  {
    name: "modality_gap",
    title: "Modality gap",
    between: "photo to touch",
    help: "distance between the mean directions of VIS and TAC; dashed: the raw embedding",
    good: "lower",
  },
  {
    name: "domain_gap",
    title: "Domain gap",
    between: "domain to domain",
    help: "mean distance between the mean directions of two domains; dashed: the raw embedding",
    good: "lower",
  },
  {
    name: "accuracy",
    title: "Accuracy",
    help: "share of pairs that the whole head predicts correctly in unseen domains; dashed: chance",
    good: "higher",
  },
  {
    name: "margin",
    title: "Cosine margin",
    between: "class to class",
    help: "mean cosine within classes minus between classes; dashed: the raw embedding",
    good: "higher",
  },
];

const series = (frames, name) => frames.meta.curves[name] ?? null;
const isSource = (frames, domain) => domain === frames.meta.head?.source;

/** The name of an accuracy curve over several trainings, without its suffix. */
const trainedAccuracy = (frames, domain) =>
  `seeds:accuracy/${!domain ? "unseen" : isSource(frames, domain) ? "source_test" : domain}`;

/** Accuracy excludes training pairs; the source has one only if heads were retrained. */
function accuracy(frames, domain) {
  if (frames.kind === "retrained") return series(frames, `${trainedAccuracy(frames, domain)}/mean`);
  if (!domain) return series(frames, "accuracy/unseen");
  return isSource(frames, domain) ? null : series(frames, `accuracy/${domain}`);
}

/** The values of one measure at one stage, of one domain if named; null if not measured. */
export function values(frames, name, stage, domain = "") {
  if (name === "accuracy") return accuracy(frames, domain);
  return series(frames, `${name}/${featuresOf(stage)}${domain && `/${domain}`}`);
}

/** Minimum and maximum over trainings: {low, high}, or null for a single training. */
export function spread(frames, name, stage, domain = "") {
  if (frames.kind !== "retrained") return null;
  const stem = name === "accuracy" ? trainedAccuracy(frames, domain) : `seeds:${name}/${featuresOf(stage)}`;
  const [low, high] = ["low", "high"].map((end) => series(frames, `${stem}/${end}`));
  return low && high && !(name !== "accuracy" && domain) ? { low, high } : null;
}

/** One axis for a measure at every stage, domain and stop: a flat line stays flat. */
export function axis(frames, name) {
  if (name === "accuracy") return [0, 1];
  const all = Object.entries(frames.meta.curves)
    .filter(([key]) => key.startsWith(`${name}/`))
    .flatMap(([, own]) => own.filter(Number.isFinite));
  const top = Math.max(0.1, ...all);
  const low = Math.min(0, ...all);
  const step = 10 ** Math.floor(Math.log10(top)) / 2;
  return [Math.floor(low / step) * step, Math.ceil(top / step - 1e-9) * step];
}

export const asText = (name, value, digits = 3) =>
  !Number.isFinite(value) ? "–" : name === "accuracy" ? `${(100 * value).toFixed(1)}\u00a0%` : value.toFixed(digits);
