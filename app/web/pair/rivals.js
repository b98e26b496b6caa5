/** The same pair, predicted by the comparison heads. Text in, HTML out. */

import { imagesOf } from "../shared/images.js";
import { escaped, percent } from "../shared/text.js";
import { best, READINGS, unlike } from "./verdict.js";

/** `images`: familiarity of each image; a reading that is a guess has no figure. All heads share the encoder. */
export function rivalsHtml(answer, others, images) {
  const heading = READINGS.map(([, title, sign]) => `<th scope="col"><span class="sign ${sign}"></span>${title}</th>`);
  const lines = others.map((one) =>
    one.problem
      ? `<tr><th scope="row">${escaped(one.label)}</th><td colspan="3">${escaped(one.problem)}</td></tr>`
      : line(one.label, one, images),
  );
  return `<header><h3>The same pair, other heads</h3><p class="hint">Each at its own learned p.</p></header><div class="scroll" tabindex="0" role="group" aria-label="Predictions of several heads"><table><thead><tr><th scope="col">Head</th>${heading.join("")}</tr></thead><tbody>${line("this head", answer, images)}${lines.join("")}</tbody></table></div>`;
}

function line(label, { classes, learned, exact }, images) {
  const given = imagesOf(exact.readings);
  const cells = READINGS.map(([reading]) => {
    const row = exact.readings[reading];
    if (!row) return "<td>–</td>";
    const found = best(classes, row);
    if (unlike(reading, given, images).length) return `<td class="of-guess">${escaped(found.label)}?</td>`;
    return `<td>${escaped(found.label)} <b>${percent(found.share)}</b></td>`;
  });
  return `<tr><th scope="row">${escaped(label)} <small>p = ${learned.toFixed(3)}</small></th>${cells.join("")}</tr>`;
}
