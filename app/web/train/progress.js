/** The state of a training, in words. No DOM here. */

import { percent } from "../shared/text.js";

/** One sentence for a state from the server. */
export function standing({ state, place, text, problem }, { epochs, total }) {
  if (state === "waiting" && !place) return "Waiting.";
  if (state === "waiting") return `Waiting: place ${place} in the queue. One training runs at a time.`;
  if (state === "running" && epochs >= total) return "Calibrating probabilities on held-out pairs.";
  if (state === "running") return epochs ? `Training: ${text} of ${total}.` : `Starting: ${text}.`;
  if (state === "cancelled") return `Cancelled after ${epochs} of ${total} epochs.`;
  if (state === "failed") return problem;
  return `Done: ${total} epochs.`;
}

/** The measures of the newest epoch up to `at` (from 1) that has any. */
export function measuredAt(epochs, at) {
  for (let i = Math.min(at, epochs.length) - 1; i >= 0; i--) {
    if (Object.keys(epochs[i].measures).length) return epochs[i].measures;
  }
  return {};
}

/** The newest map up to epoch `at`, as base64; null if there is none yet. */
export function mapAt(epochs, at) {
  for (let i = Math.min(at, epochs.length) - 1; i >= 0; i--)
    if (epochs[i].map) return { map: epochs[i].map, epoch: epochs[i].epoch };
  return null;
}

/** The result of a run for the list of earlier ones. */
export function result(epochs) {
  const measures = measuredAt(epochs, epochs.length);
  const unseen = measures["accuracy/unseen"];
  return {
    order: epochs.at(-1)?.order,
    unseen: Number.isFinite(unseen) ? percent(unseen, 1) : "–",
    modality: measures["modality_gap/f_hat"]?.toFixed(2) ?? "–",
    domain: measures["domain_gap/f_hat"]?.toFixed(2) ?? "–",
  };
}
