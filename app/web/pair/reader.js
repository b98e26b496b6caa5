/** Which head reads the visitor's own pictures, and what it reads right in sensors that it has not seen. */

import { button, folded, hint, html, percent, READINGS, readFrom, row, signed, table } from "./parts.js";

/** The most pictures without labels that the record has. @param {Partial<OwnReader>} facts */
const mostOf = ({ left_out: shares = {} }) => Math.max(...Object.keys(shares).map(Number));

/** What pictures without labels bring, in words. @param {Partial<OwnReader>} facts */
export function gainOf(facts) {
  const most = mostOf(facts);
  const [none, some] = [0, most].map((count) => facts.left_out?.[count].fused ?? NaN);
  const [from, to] = [percent(none, 1), percent(some, 1)];
  return `On unseen simulated sensors, a profile of ${most} unlabelled pictures raises accuracy from ${from} to ${to}.`;
}

/** What to know of a reading of the visitor's own pictures: what the head that made it read right on real pairs.
 * Nothing for other pictures, for a guess, which has no figure, and for a head that the visitor's labels taught.
 * @param {Pick<PairTab, "facts" | "tested" | "simulated" | "head" | "taught" | "profile" | "vis" | "tac">} tab
 * @param {Pick<Said, "reading" | "used" | "guess">} said */
export function cautionOf(tab, { reading, used, guess }) {
  if (tab.taught || guess || !used.some((name) => tab[name]?.startsWith("image:"))) return null;
  const real = realOf(tab);
  if (!real) return tab.simulated ? html`<b>Do not trust this.</b> ${UNTESTED}` : null;
  const right = counts(real, tab)[reading];
  return html`${right <= real.always && html`<b>At chance: do not trust this.</b> `}On ${real.pairs} real pairs, this
    reading was correct for ${right}; always naming the most frequent class, for ${real.always}.`;
}

/** The same for a table of pairs, in one sentence. @param {PairTab} tab */
export function cautionsOf(tab) {
  const real = realOf(tab);
  if (tab.taught || (!real && !tab.simulated)) return null;
  if (!real) return html`<b>Do not trust these predictions.</b> ${UNTESTED}`;
  const words = READINGS.map((reading) => `for ${counts(real, tab)[reading]} ${readFrom(reading)}`);
  return html`<b>Do not trust single predictions.</b> On ${real.pairs} real pairs, the head was
    correct ${words.join(", ")}; always naming the most frequent class was correct for ${real.always}.`;
}

const UNTESTED = "The head was trained on simulated pairs and was never tested on real ones.";
/** What the head that reads own pictures read right on real pairs, if measured.
 * @param {Pick<PairTab, "facts" | "tested" | "head">} tab */
const realOf = ({ facts, tested, head }) => (head ? facts.real : tested);
/** @param {NonNullable<OwnReader["real"]>} real @param {Pick<PairTab, "profile">} tab */
const counts = (real, { profile }) => real[profile ? "profile" : "as they come"];

/** facts: of the head for own pictures; on: whether it reads; source: what the other head learned from.
 * @param {Partial<OwnReader>} facts @param {boolean} on @param {string} source */
export function readerHtml(facts, on, source) {
  const other = (/** @type {string} */ words) => button("readerSwitched", words, html`class="reader-switch"`);
  if (!on)
    return html`${hint(`The head of the chapters, trained on ${source} only, reads your pictures.`)}
      ${other("Use the head for own pictures")}`;
  const { left_out: shares = {}, real } = facts;
  const most = mostOf(facts);
  const rows = READINGS.map((reading) =>
    row(signed(reading), [
      percent(shares[0][reading]),
      percent(shares[most][reading]),
      ...(real ? [String(real["as they come"][reading]), `${real.profile[reading]} of ${real.pairs}`] : []),
    ]),
  );
  const heads = ["Correct", "simulated, raw", `with ${most} pictures`];
  if (real) heads.push("real, raw", "with a profile");
  return html`${hint("The head for own pictures, trained on all simulated sensors, reads your pictures.")}
    ${folded("How often is it correct?", table("Pairs that the head for own pictures reads correctly", heads, rows))}
    ${other("Use the head of the chapters")}`;
}
