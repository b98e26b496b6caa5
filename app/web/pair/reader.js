/** Which head reads the visitor's own pictures, and what it reads right in sensors that it has not seen. */

import { button, folded, hint, html, IMAGES, percent, READINGS, row, signed, table } from "./parts.js";

/** The most pictures without labels that the record has. @param {Partial<OwnReader>} facts */
const mostOf = ({ left_out: shares = {} }) => Math.max(...Object.keys(shares).map(Number));

/** What pictures without labels bring, in words. @param {Partial<OwnReader>} facts */
export function gainOf(facts) {
  const most = mostOf(facts);
  const [none, some] = [0, most].map((count) => facts.left_out?.[count].fused ?? NaN);
  return `${most} pictures without labels bring ${(100 * (some - none)).toFixed(1)} points on simulated sensors that it has not seen: ${percent(some)} of pairs right, ${percent(none)} without.`;
}

/** The modalities that are no better than naming the most frequent class on real pairs, even with a profile.
 * @param {Partial<OwnReader>} facts */
export const atChance = ({ real }) => IMAGES.filter((name) => real && real.profile[name] <= real.always);

/** facts: of the head for own pictures; on: whether it reads; source: what the other head learned from.
 * @param {Partial<OwnReader>} facts @param {boolean} on @param {string} source */
export function readerHtml(facts, on, source) {
  const other = (/** @type {string} */ words) => button("readerSwitched", words, html`class="reader-switch"`);
  if (!on)
    return html`${hint(`Your pictures are read by the head of the chapters, which learned from ${source} alone.`)}${other("Use the head for own pictures")}`;
  const { left_out: shares = {}, real } = facts;
  const most = mostOf(facts);
  const rows = READINGS.map((reading) =>
    row(signed(reading), [
      percent(shares[0][reading]),
      percent(shares[most][reading]),
      ...(real ? [String(real["as they come"][reading]), `${real.profile[reading]} of ${real.pairs}`] : []),
    ]),
  );
  const heads = ["It reads right", "simulated, as they come", `with ${most} pictures`];
  if (real) heads.push("real, as they come", "with a profile");
  const chance = atChance(facts).map((name) => (name === "tac" ? "touch" : "photo"));
  const note =
    real &&
    chance.length > 0 &&
    hint(
      html`<b>On real pairs its reading of the ${chance.join(" and the ")} is at chance</b>: always naming the most frequent class is right for ${real.always} of ${real.pairs}. Do not trust it.`,
    );
  return html`${hint("Read by the head for own pictures, which learned from all simulated sensors.")}${note}${folded("Photo and touch apart", table("What the head for own pictures reads right", heads, rows))}${other("Use the head of the chapters")}`;
}
