/** The same pair, predicted by the comparison heads. Text in, HTML out. */

import { escaped, percent } from "../shared/text.js";
import { best, READINGS } from "./verdict.js";

export function rivalsHtml(answer, others) {
  const heading = READINGS.map(
    ([, title, sign]) => `<th scope="col"><span class="sign ${sign}"></span>${title}</th>`,
  );
  const lines = others.map((one) =>
    one.problem
      ? `<tr><th scope="row">${escaped(one.label)}</th><td colspan="3">${escaped(one.problem)}</td></tr>`
      : line(one.label, one),
  );
  return `<header><h3>The same pair, other heads</h3><p class="hint">Each at its own learned p.</p></header><div class="scroll" tabindex="0" role="group" aria-label="Predictions of several heads"><table><thead><tr><th scope="col">Head</th>${heading.join("")}</tr></thead><tbody>${line("this head", answer)}${lines.join("")}</tbody></table></div>`;
}

function line(label, { classes, learned, exact }) {
  const cells = READINGS.map(([reading]) => {
    const row = exact.readings[reading];
    if (!row) return "<td>–</td>";
    const found = best(classes, row);
    return `<td>${escaped(found.label)} <b>${percent(found.share)}</b></td>`;
  });
  return `<tr><th scope="row">${escaped(label)} <small>p = ${learned.toFixed(3)}</small></th>${cells.join("")}</tr>`;
}
