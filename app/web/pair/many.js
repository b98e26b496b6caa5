/** Many pairs at once: a table of predictions with guess marks, and a CSV. */

import { csv as written } from "../shared/csv.js";
import { asTrained } from "./own.js";
import {
  button,
  headed,
  html,
  kinds,
  opener,
  paragraph,
  plural,
  READINGS,
  readFrom,
  row,
  status,
  table,
  titleOf,
} from "./parts.js";
import { cautionsOf } from "./reader.js";
import { joined, labelledOf, missing, tallies } from "./state.js";
import { brief, readingsOf } from "./verdict.js";

/** The panel; null without pairs. @param {PairTab} tab */
export function manyHtml(tab) {
  const { rows, unnamed, notes, doing } = tab;
  const close = button("closed", "Close");
  if (doing.read) {
    const { done, total, wait } = doing.read;
    const left = wait ? ` About ${wait} s left.` : "";
    return html`<div class="stand"><p>Reading pair ${done} of ${total}…${left}</p>
      <progress value="${done / total}" aria-label="Pairs"></progress>${button("stopped", "Cancel")}</div>`;
  }
  if (rows.length) return tableHtml(tab, close);
  if (!unnamed && !notes.many) return null;
  const question =
    unnamed &&
    `The names of ${plural(unnamed.count, "picture")} contain neither vis nor tac. Are they photos or touches?`;
  return html`<div class="stand"><p role="status">${question ?? notes.many}</p>${unnamed && kinds("dropped")}
    ${close}</div>`;
}

/** @param {PairTab} tab @param {Html} close */
function tableHtml(tab, close) {
  const { rows, taught, notes } = tab;
  const guesses = rows.filter((row) => saidOf(row).some(({ guess }) => guess));
  const labelled = labelledOf(rows);
  const scores = tallies(labelled).map(({ reading, right, of }) => `${readFrom(reading)}: ${right} of ${of}`);
  const caution = cautionsOf(tab);
  const lacking = missing(joined(tab, rows));
  const count = taught ? leftOut(tab) : scores.length && `Correct ${scores.join(", ")}. `;
  const names = new Set(rows.flatMap(({ classes = [], label }) => [...classes, label || []].flat()));
  const size = plural(rows.length, "pair");
  const acts = html`<span class="row">${button(
    "rowsProfiled",
    "Profile of these",
    html`title="Make a profile of these
    pictures: their mean and spread, without labels"`,
  )}
    ${button("rowsTaught", "Teach", html`class="main" title="${lacking}"${lacking && " disabled"}`)}
    ${button("csv", "Save as CSV")}${close}</span>`;
  return html`${headed(`${size}: ${plural(guesses.length, "guess", "guesses")}`, acts)}
    ${status(html`${count || null}“?” marks a guess: the picture is
      unlike ${taught ? "those that you labelled" : "all training images"}. Type the true class as a label. Click a
      name to open its pair.${notes.many}`)}
    ${caution && paragraph("caution", caution)}
    ${!taught && scores.length > 0 && asTrained(tab, `${labelled.length} labelled of your ${size}`)}
    <datalist id="ov-classes">${[...names].map((name) => html`<option value="${name}">`)}</datalist>
    ${table(
      "Your pairs and their predictions",
      ["Pair", "Label", ...READINGS.map(titleOf)],
      rows.map((row, i) => rowHtml(row, i, taught)),
    )}`;
}

/** The honest figure of a taught head, before a table that is none. @param {Pick<PairTab, "report">} tab */
const leftOut = ({ report }) =>
  report &&
  html`<b>With each pair left out, the taught head is correct
    for ${report.right.after} of ${report.judged.length}.</b> The table looks better, because the head was
    taught with these labels. `;

/** What each reading of a row predicts. @param {Row} row */
const saidOf = ({ classes = [], readings = {}, images }) => readingsOf({ classes, readings, images });

/** @param {Row} one @param {number} i @param {boolean} taught */
function rowHtml(one, i, taught) {
  const { name, label, vis, tac, said } = one;
  if (!said) return row(html`${name}`, [html`<td colspan="4" class="wrong">${one.problem}</td>`]);
  const cells = saidOf(one).map((said) => {
    const mark = label && said.label && (label === said.label ? "right" : "wrong");
    return html`<td class="${mark}">${brief(said)}</td>`;
  });
  const open = opener(name, { vis, tac }, html`class="link"`);
  const field = html`<input type="text" list="ov-classes" maxlength="40" size="9" name="value" data-send="rowLabelled"
    data-label="${i}" aria-label="Label of ${name}" value="${label}">`;
  return row(html`${open} ${taught && label && html`<small>used for teaching</small>`}`, [field, ...cells]);
}

/** One line for each pair: label, and class, probability and guess of each reading. @param {Row[]} rows */
export function csv(rows) {
  const names = READINGS.flatMap((reading) => [reading, `${reading}_probability`, `${reading}_guess`]);
  const lines = rows.map((row) => {
    const cells = saidOf(row).flatMap(({ label, share, guess }) =>
      label ? [label, share.toFixed(4), String(guess)] : ["", "", ""],
    );
    return [row.name, row.label, ...cells, row.problem ?? ""];
  });
  return written([["pair", "label", ...names, "problem"], ...lines]);
}
