/** Which head reads the visitor's own pictures, and what it reads right in sensors that it has not seen. */

import { escaped, percent, row, table } from "../shared/text.js";
import { READINGS } from "./verdict.js";

const MANY = "20"; // pictures without labels of the record

/** What pictures without labels bring, in words. */
export function gainOf({ left_out: found }) {
  const [none, some] = ["0", MANY].map((count) => found[count].fused);
  return `${MANY} pictures without labels bring ${(100 * (some - none)).toFixed(1)} points on simulated sensors that it has not seen: ${percent(some)} of pairs right, ${percent(none)} without.`;
}

/** The modalities that are no better than naming the most frequent class on real pairs, even with a profile. */
export const atChance = ({ real }) => ["vis", "tac"].filter((name) => real && real.profile[name] <= real.always);

/** facts: of the head for own pictures; on: whether it reads; source: what the other head learned from. */
export function readerHtml(facts, on, source) {
  if (!on)
    return `<p class="hint">Your pictures are read by the head of the chapters, which learned from ${escaped(source)} alone.</p><button type="button" class="reader-switch">Use the head for own pictures</button>`;
  const { left_out: found, real } = facts;
  const rows = READINGS.map(([reading, title, sign]) =>
    row(`<span class="sign ${sign}"></span>${title}`, [
      percent(found[0][reading]),
      percent(found[MANY][reading]),
      ...(real ? [`${real["as they come"][reading]}`, `${real.profile[reading]} of ${real.pairs}`] : []),
    ]),
  );
  const heads = ["It reads right", "simulated, as they come", `with ${MANY} pictures`];
  if (real) heads.push("real, as they come", "with a profile");
  const chance = atChance(facts).map((name) => (name === "tac" ? "touch" : "photo"));
  const note = chance.length
    ? `<p class="hint"><b>On real pairs its reading of the ${chance.join(" and the ")} is at chance</b>: always naming the most frequent class is right for ${real.always} of ${real.pairs}. Do not trust it.</p>`
    : "";
  return `<p class="hint">Read by the head for own pictures, which learned from all simulated sensors.</p>${note}<details><summary>Photo and touch apart</summary>${table("What the head for own pictures reads right", heads, rows)}</details><button type="button" class="reader-switch">Use the head of the chapters</button>`;
}
