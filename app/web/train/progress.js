/** The state of a training, in words. No DOM here. */

import { percent } from "../shared/text.js";

/** One sentence for a state from the server. */
export function standing({ state, place, text, left, problem }, { epochs, total }) {
  if (state === "waiting" && !place) return "Waiting.";
  if (state === "waiting") return `Waiting: place ${place} in the queue. One training runs at a time.`;
  if (state === "running" && epochs >= total) return "Calibrating probabilities on held-out pairs.";
  if (state === "running")
    return epochs ? `Training: ${text} of ${total}${left ? `, ${left}` : ""}.` : `Starting: ${text}.`;
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
    share: unseen,
    unseen: Number.isFinite(unseen) ? percent(unseen, 1) : "–",
    modality: measures["modality_gap/f_hat"]?.toFixed(2) ?? "–",
    domain: measures["domain_gap/f_hat"]?.toFixed(2) ?? "–",
  };
}

/** The last two runs beside the spread of seeds: std of one training over its seeds, or null if unknown. */
export function compared(runs, std) {
  const [a, b] = runs.slice(-2).map(({ share }) => share);
  if (runs.length < 2 || !Number.isFinite(a + b)) return "";
  const points = (v) => `${(100 * v).toFixed(1)} points`;
  const said = `The last run is ${points(Math.abs(b - a))} ${b < a ? "below" : "above"} the one before it.`;
  if (std === null) return `${said} Train the same settings with other seeds to see how much is chance.`;
  const chance = Math.SQRT2 * std; // of the difference of two trainings
  const verdict = Math.abs(b - a) > 2 * chance ? "so this is more than seeds explain" : "so this may be chance";
  return `${said} Two seeds of the same settings differ by about ${points(chance)} (standard deviation), ${verdict}.`;
}
