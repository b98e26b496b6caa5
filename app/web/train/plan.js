/** A training in words: its settings as a form and back, its progress, and the visitor it belongs to. */

import { keptJson, kept as read, keep as write } from "../shared/memory.js";
import { each, options, percent } from "../shared/text.js";

const ORDERS = {
  gradient: "learn p by gradient",
  fixed: "keep p fixed",
  search: "search for p",
  every: "train for every p",
};
// label and step; the form accepts what the server accepts
const NUMBERS = {
  p: ["initial p", "any"],
  mma: ["λ, weight of MMA", "any"],
  levels: ["R, tree levels", 1],
  expansion: ["E, tokens", 1],
  noise: ["noise on embeddings, std", "any"],
  shift: ["imitated sensors, std", "any"],
  epochs: ["Epochs", 1],
  seed: ["Seed", 1],
};

/** The form; `offers` are the server's choices. */
export function formHtml({ sources, widths, orders, ranges, first }) {
  const select = (name, label, values, text = (v) => v) =>
    `<label>${label}<select name="${name}">${options(
      values.map((v) => [v, text(v)]),
      first[name],
    )}</select></label>`;
  const number = (name) => {
    const [label, step] = NUMBERS[name];
    const [low, high] = ranges[name];
    return `<label>${label}<input type="number" name="${name}" min="${low}" max="${high}" step="${step}" value="${first[name]}" required></label>`;
  };
  return `${select("source", "Learn from", sources)}${select("order", "What p does", orders, (v) => ORDERS[v])}
    <div class="row"><button type="submit" class="main go">Train</button><button type="button" class="stop" hidden>Cancel</button></div>
    <details class="advanced"><summary>Advanced</summary>${select("width", "D, width", widths)}${each(["p", "mma", "levels", "expansion", "noise", "shift", "epochs", "seed"], number)}
    <label class="check"><input type="checkbox" name="lang" ${first.lang ? "checked" : ""}> LANG guides the training</label></details>`;
}

/** The form's values for the server. entries: name -> text, of a FormData. */
export function chosen(entries) {
  const found = Object.fromEntries(entries);
  const question = { source: found.source, width: Number(found.width), order: found.order, lang: "lang" in found };
  for (const name of Object.keys(NUMBERS)) question[name] = Number(found[name]);
  return question;
}

/** The settings in one line. */
export const inWords = (q) =>
  `${q.source}, D = ${q.width}, ${ORDERS[q.order]}${q.order === "fixed" ? ` = ${q.p}` : ""}, λ = ${q.mma}, R = ${q.levels}, E = ${q.expansion}, ${q.noise ? `noise ${q.noise}, ` : ""}${q.shift ? `imitated sensors ${q.shift}, ` : ""}${q.lang ? "LANG" : "no LANG"}, seed ${q.seed}`;

/** A state from the server in words. leftOut: pairs of the source without a class */
export function standing(state, { epochs, total, leftOut = 0 }) {
  const words = stateInWords(state, epochs, total);
  if (!leftOut || ["failed", "cancelled"].includes(state.state)) return words;
  return `${words} ${leftOut === 1 ? "1 pair without a class is" : `${leftOut} pairs without a class are`} left out.`;
}

function stateInWords({ state, place, text, left, problem }, epochs, total) {
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

/** The last two runs in words. */
export function compared(runs) {
  const [a, b] = runs.slice(-2).map(({ share }) => share);
  if (runs.length < 2 || !Number.isFinite(a + b)) return "";
  const points = `${(100 * Math.abs(b - a)).toFixed(1)} points`;
  return `The last run is ${points} ${b < a ? "below" : "above"} the one before it. Train the same settings with other seeds to see how much is chance.`;
}

const NAME = "omnivat-visitor";
const TRAINING = "omnivat-training";

/** A name, so that the server allows one training for each visitor. */
export function visitor() {
  const made = read(NAME) ?? [...crypto.getRandomValues(new Uint32Array(4))].map((n) => n.toString(36)).join("");
  write(NAME, made);
  return made;
}

/** Keep the training {started, question}; null forgets it. */
export const keep = (training) => write(TRAINING, JSON.stringify(training));

/** The kept training, or null. */
export const kept = () => keptJson(TRAINING, null);
