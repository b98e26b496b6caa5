/** The settings of a training, as a form and back. Text in, HTML out. */

import { options } from "../shared/text.js";

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
    <details class="advanced"><summary>Advanced</summary>${select("width", "D, width", widths)}${["p", "mma", "levels", "expansion", "noise", "epochs", "seed"].map(number).join("")}
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
  `${q.source}, D = ${q.width}, ${ORDERS[q.order]}${q.order === "fixed" ? ` = ${q.p}` : ""}, λ = ${q.mma}, R = ${q.levels}, E = ${q.expansion}, ${q.noise ? `noise ${q.noise}, ` : ""}${q.lang ? "LANG" : "no LANG"}, seed ${q.seed}`;
