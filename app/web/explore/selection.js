/** The table of the selected points. */

import { imitation, saidHtml, thumbnailPair, verdict } from "../shared/card.js";
import { orderText } from "../shared/frames.js";
import { escaped, percent } from "../shared/text.js";

const ROWS = 60; // shown; the CSV holds all

export function showSelection(box, { frames, sprite, points, stop, pairs: facts, onPick, onClear, onSave }) {
  box.hidden = !points.length;
  if (!points.length) return;
  const pairs = [...new Set(points.map((point) => point % frames.pairs))].sort((a, b) => a - b);
  const verdicts = pairs.map((pair) => verdict(frames, pair, stop));
  const right = verdicts.filter((v) => v.right).length;
  const vis = points.filter((point) => point < frames.pairs).length;
  const tally = (key) =>
    Object.entries(Object.groupBy(verdicts, (v) => v[key]))
      .sort((a, b) => b[1].length - a[1].length)
      .map(([name, own]) => `${escaped(name)} ${own.length}`)
      .join(" · ");
  box.innerHTML = `<header><h3>${points.length} points selected</h3>
    <p>${vis} VIS, ${points.length - vis} TAC of ${pairs.length} pairs; ${percent(right / pairs.length)} predicted right ${frames.kind === "retrained" ? "by the head trained " : ""}at p = ${orderText(frames.orders[stop])}.<br>
    <b>Domains</b> ${tally("domain")}<br><b>Classes</b> ${tally("truth")}</p>
    <span class="row"><button type="button" class="csv">Save as CSV</button><button type="button" class="clear">Clear</button></span></header>
    <div class="scroll" tabindex="0" aria-label="Selected pairs"><table><thead><tr><th>Pair</th><th>VIS and TAC</th><th>Domain</th><th>Class</th><th>Predicted</th></tr></thead><tbody>
    ${pairs
      .slice(0, ROWS)
      .map(
        (
          pair,
          i,
        ) => `<tr><td><button type="button" class="link" data-pair="${pair}">${pair}</button></td><td>${thumbnailPair(frames, sprite, pair, 40)}</td>
      <td>${escaped(verdicts[i].domain)}</td><td>${escaped(verdicts[i].truth)}${imitation(facts, pair) && ` <small>${escaped(imitation(facts, pair))}</small>`}</td><td class="${verdicts[i].right ? "right" : "wrong"}">${saidHtml(verdicts[i])}</td></tr>`,
      )
      .join("")}
    </tbody></table>${pairs.length > ROWS ? `<p class="hint">${pairs.length - ROWS} more pairs are in the CSV.</p>` : ""}</div>`;
  box.onclick = (event) => {
    if (event.target.matches(".csv")) onSave();
    if (event.target.matches(".clear")) onClear();
    const button = event.target.closest("[data-pair]");
    if (button) onPick(+button.dataset.pair);
  };
}
