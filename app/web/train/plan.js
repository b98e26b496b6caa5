/** A training in words: its settings as a form and back, its progress, and the visitor it belongs to. */

import { keptJson, kept as read, keep as write } from "../shared/memory.js";
import { html, options, percent } from "../shared/text.js";

/** The form; `offers` are the server's choices. @param {Offers} offers */
export function formHtml({ sources, widths, orders, numbers, first }) {
  /** @param {"source" | "order" | "width"} name @param {string} label @param {(string | number)[][]} all */
  const select = (name, label, all) =>
    html`<label><span>${label}</span><select name="${name}">${options(all, first[name])}</select></label>`;
  const fields = numbers.map(
    ({ name, words, least, most, step }) =>
      html`<label><span>${words}</span><input type="number" name="${name}" min="${least}" max="${most}" step="${step}" value="${first[name]}" required></label>`,
  );
  /** @param {string | number} value */
  const itself = (value) => [value, value];
  return html`${select("source", "Learn from", sources.map(itself))}${select("order", "What p does", orders)}
    <div class="row"><button type="submit" class="main go">Train</button><button type="button" class="stop" hidden>Cancel</button></div>
    <details class="advanced"><summary>Advanced</summary>${select("width", "D, width", widths.map(itself))}${fields}
    <label class="check"><input type="checkbox" name="lang"${first.lang && html` checked`}> LANG guides the training</label></details>`;
}

/** The form's values for the server. @param {Iterable<[name: string, value: FormDataEntryValue]>} entries @returns {Settings} */
export function chosen(entries) {
  const { source, order, lang, ...rest } = Object.fromEntries(entries);
  const numbers = Object.fromEntries(Object.entries(rest).map(([name, value]) => [name, Number(value)]));
  return /** @type {any} */ ({ source, order, lang: lang !== undefined, ...numbers });
}

/** How far a run is, in words, and how many pairs of its source have no class. @param {Run} run */
export function standing({ standing: { state, place, text, left, problem }, epochs: { length }, started }) {
  const { total, left_out: lost } = started;
  if (state === "failed") return problem;
  if (state === "cancelled") return `Cancelled after ${length} of ${total} epochs.`;
  const words =
    state === "waiting"
      ? `Waiting${place ? `: place ${place} in the queue. One training runs at a time` : ""}`
      : state === "done"
        ? `Done: ${total} epochs`
        : length >= total
          ? "Calibrating probabilities on held-out pairs"
          : length
            ? `Training: ${text} of ${total}${left && `, ${left}`}`
            : `Starting: ${text}`;
  const without =
    lost && ` ${lost === 1 ? "1 pair without a class is" : `${lost} pairs without a class are`} left out.`;
  return `${words}.${without || ""}`;
}

/** The newest map up to epoch `at`, as base64; null if there is none yet. @param {Epoch[]} epochs @param {number} at */
export const mapAt = (epochs, at) => epochs.slice(0, at).findLast(({ map }) => map)?.map ?? null;

/** The measures of the newest epoch that has any. @param {Run} run */
const measures = ({ epochs }) => epochs.findLast((epoch) => Object.keys(epoch.measures).length)?.measures ?? {};

/** The result of a run as cells: p, accuracy in unseen domains, both gaps. @param {Run} run */
export function result(run) {
  const { "accuracy/unseen": unseen, "modality_gap/f_hat": modality, "domain_gap/f_hat": domain } = measures(run);
  return [
    run.epochs.at(-1)?.order.toFixed(3) ?? "–",
    Number.isFinite(unseen) ? percent(unseen, 1) : "–",
    modality?.toFixed(2) ?? "–",
    domain?.toFixed(2) ?? "–",
  ];
}

/** The last two runs in words; "" for one, or without a figure. @param {Run[]} runs */
export function compared(runs) {
  const [before, last = NaN] = runs.slice(-2).map((run) => measures(run)["accuracy/unseen"]);
  const points = 100 * (last - before);
  if (!Number.isFinite(points)) return "";
  return `The last run is ${Math.abs(points).toFixed(1)} points ${points < 0 ? "below" : "above"} the one before it. Train the same settings with other seeds to see how much is chance.`;
}

const NAME = "omnivat-visitor";
const TRAINING = "omnivat-training";

/** A name, so that the server allows one training for each visitor. */
export function visitor() {
  const made = read(NAME) ?? [...crypto.getRandomValues(new Uint32Array(4))].map((n) => n.toString(36)).join("");
  write(NAME, made);
  return made;
}

/** Keep the training; null forgets it. @param {KeptRun | null} training */
export const keep = (training) => write(TRAINING, JSON.stringify(training));

/** The kept training, or null. @returns {KeptRun | null} */
export const kept = () => keptJson(TRAINING, null);
