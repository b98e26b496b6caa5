/** The visitor's own pairs: labels, a running count, and what teaching brought. */

import { Scale } from "../shared/chart.js";
import { provenance } from "../shared/provenance.js";
import { sensorOf } from "../shared/tables.js";
import { button, headed, hint, html, opener, percent, pressed, readFrom, row, signed, status, table } from "./parts.js";
import { isHeld, isOwn, keyOf, labelOf, missing, tallies } from "./state.js";

/** What the head that reads own pictures was trained on. @param {PairTab} tab */
const sourceOf = ({ head, source }) => (head ? "all simulated sensors" : sensorOf(source));
/** Where a count of own pairs comes from. @param {PairTab} tab @param {string} pairs */
export const asTrained = (tab, pairs) =>
  provenance({
    head: "the head before teaching",
    source: sourceOf(tab),
    pairs,
    known: tab.profile ? "a profile of your pictures, without labels" : "nothing from your sensor",
  });

/** The panel; null without a pair of the visitor's. @param {PairTab} tab */
export function ownHtml(tab) {
  const { classes, pairs, notes } = tab;
  if (!classes.length || (!pairs.length && !isOwn(tab))) return null;
  const counted = pairs.length
    ? [countedHtml(tab), teachingHtml(tab)]
    : hint("Choose the true class. The page then counts how often its predictions are correct.");
  return html`${isOwn(tab) && questionHtml(tab)}${counted}${status(notes.own)}`;
}

/** @param {PairTab} tab */
function questionHtml(tab) {
  const chosen = labelOf(tab);
  const off = isHeld(tab) && " disabled";
  const buttons = [...new Set([...tab.classes, ...tab.pairs.map(({ label }) => label)])].map((name) =>
    button("answered", name, html`data-label="${name}"${off} ${pressed(name === chosen)}`),
  );
  return html`${headed("What is the true class?")}<form class="row labels">${buttons}
    <label>another class <input type="text" name="label" maxlength="40" size="10"${off}></label>
    <button type="submit"${off}>Add</button></form>`;
}

/** @param {PairTab} tab */
function countedHtml(tab) {
  const { pairs } = tab;
  const scores = tallies(pairs).map(
    ({ reading, right, of }) => html`<span>${signed(reading, readFrom(reading))}: <b>${right} of ${of}</b></span> `,
  );
  const chips = pairs.map(({ vis, tac, label, name }) => {
    const open = opener(html`${label}<small>${name}</small>`, { vis, tac }, html`class="open"`);
    const key = html`class="drop" data-key="${keyOf({ vis, tac })}" aria-label="Forget ${name}"`;
    return html`<li>${open}${button("forgotten", "×", key)}</li>`;
  });
  return html`<div class="tally"><b>Correct so far:</b> ${scores}</div>
    ${asTrained(tab, `your ${pairs.length} labelled pairs`)}<ul class="row chips">${chips}</ul>`;
}

/** @param {PairTab} tab */
function teachingHtml(tab) {
  const lacking = missing(tab.pairs);
  const report = tab.report && reportHtml(tab.report, tab.labels, sourceOf(tab));
  const save = (/** @type {string} */ words, /** @type {string} */ path, /** @type {string} */ name, title = "") =>
    button("save", words, html`data-path="${path}" data-name="${name}" title="${title}"`);
  const taught = tab.report && [
    button("used", tab.taught ? "Back to the head as trained" : "Predict with the taught head", pressed(tab.taught)),
    save("Save the taught head", "save/head", "taught-head.zip"),
  ];
  const set = "Save their embeddings as a file that this page and the commands read";
  const folders = html`title="Save the pictures in folders by class, for omnivat embed"`;
  return html`<div class="row">
    ${button("teach", "Teach it my pairs", html`class="main" title="${lacking}"${lacking && " disabled"}`)}${taught}
    ${save("Save my pairs as a set", "save/set", "my-pairs.zip", set)}
    ${button("savePictures", "Save the pictures", folders)}</div>${report}`;
}

/** What labels bring: the mean share of right pairs over objects of each class, in the band of all draws.
 * @param {Labels} labels */
export function curveHtml({ points, words }) {
  const last = points.at(-1)?.objects ?? 1;
  const scale = new Scale({ wide: 340, high: 150, pad: { left: 54, right: 12, top: 10, bottom: 22 }, xs: [1, last] });
  /** @param {"right" | "least" | "most"} of */
  const along = (of) => points.map((one) => [one.objects, one[of]]);
  const ticks = [1, last].map((count) => [count, `${count} object${count > 1 ? "s" : ""} a class`]);
  const figures = points.map(({ objects, right }) => `${objects}: ${percent(right)}`).join(", ");
  const drawn = scale.svg(
    `Share of correct pairs by number of labelled objects per class: ${figures}`,
    scale.grid([0, 0.5, 1], percent),
    scale.ticks(ticks),
    html`<path class="band" d="${scale.area(along("most"), along("least"))}"/><path class="mean"
      d="${scale.line(along("right"))}"/>`,
  );
  const how = html`Each pair is predicted by a head that was taught without it. Line: mean of ten random choices of
    objects. Band: lowest to highest.`;
  return html`<div class="labels-bring"><h4>How many more labels?</h4><p>${words}</p>
    ${points.length > 1 && [drawn, hint(how)]}</div>`;
}

/** Before and after, pair by pair. @param {Taught} report @param {Labels | null} labels @param {string} source */
function reportHtml({ judged, right, share }, labels, source) {
  const { length } = judged;
  const rows = judged.map(({ label, before, after }) =>
    row(
      html`${label}`,
      [before, after].map((said) => {
        const [mark, sign] = said === label ? ["right", "✓"] : ["wrong", "✗"];
        return html`<td class="${mark}">${sign} ${said}</td>`;
      }),
    ),
  );
  const from = provenance({
    head: "heads taught without the pair",
    source: `${source} and on your other pairs`,
    pairs: `your ${length} labelled pairs`,
    known: "the labels of your other pairs",
  });
  const how = html`The taught head adds a linear map, learned from your pairs, to the head’s own probabilities, which
    have weight ${share.toFixed(2)}. The features do not change. Each pair is predicted without it: one pair of each
    class, or a tenth of them, is left out at a time. One pair counts ${Math.round(100 / length)} points.`;
  return html`<div class="taught"><p><b>Correct before teaching: ${right.before} of ${length}. After
    teaching: ${right.after} of ${length}.</b></p>
    ${from}
    ${hint(how)}
    ${table("Your pairs before and after teaching", ["True class", "before", "after"], rows)}
      ${labels && curveHtml(labels)}</div>`;
}
