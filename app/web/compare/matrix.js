/** Scores from each source to each target, and the paper's figures. */

import { json, refused } from "../shared/api.js";
import { each, escaped, percent } from "../shared/text.js";

const METRICS = ["ACC", "macro-F1"];

export async function matrix(box) {
  let metric = 0;
  let found;
  let opened = false;
  try {
    found = await json("matrix");
  } catch (error) {
    return refused(error, (sentence) => {
      box.innerHTML = `<h3>Source × target</h3><p class="hint">${escaped(sentence)}</p>`;
    });
  }
  function show() {
    box.innerHTML = `<header><h3>Methods, ${METRICS[metric]}</h3><div class="which" role="radiogroup" aria-label="Which score">${each(
      METRICS,
      (name, i) =>
        `<button type="button" role="radio" data-metric="${i}" aria-checked="${i === metric}">${name}</button>`,
    )}</div></header>
      ${dots(found.ranking, metric)}<details class="every"${opened ? " open" : ""}><summary>Every source and target, and the paper’s figures</summary><div class="two-tables">${ours(found, metric)}${papers(found, metric)}</div></details>`;
    box.querySelector(".every").ontoggle = (event) => {
      opened = event.target.open;
    };
  }
  box.onclick = (event) => {
    const button = event.target.closest("[data-metric]");
    if (!button) return;
    metric = +button.dataset.metric;
    show();
    box.querySelector(`[data-metric="${metric}"]`).focus();
  };
  show();
}

/** The mean over targets without the source. */
function unseen(row, metric) {
  const values = Object.entries(row.cells)
    .filter(([target]) => target !== row.source)
    .map(([, cell]) => cell[metric]);
  return values.length ? values.reduce((a, b) => a + b, 0) / values.length : NaN;
}

/** The mean over a method's sources, of means over unseen targets. */
const meanOf = (rows, metric) => rows.reduce((sum, row) => sum + unseen(row, metric), 0) / rows.length;

/** A last line for methods with several sources: their mean. */
function overall(rows, targets, metric) {
  if (rows.length < 2) return "";
  return `<tr class="overall"><th scope="row" colspan="2">mean of ${rows.length} sources</th><td colspan="${targets.length}"></td><td><b>${(100 * meanOf(rows, metric)).toFixed(1)}</b></td></tr>`;
}

/** The methods in order: a dot and its 95 % interval each, on one axis. */
export function dots(ranking, metric) {
  if (ranking.length < 2) return "";
  const all = ranking.map(({ scores }) => scores[metric]);
  const low = Math.floor(20 * Math.min(...all.map((one) => one[1]))) / 20;
  const high = Math.ceil(20 * Math.max(...all.map((one) => one[2]))) / 20;
  const at = (v) => `${((100 * (v - low)) / (high - low)).toFixed(2)}%`;
  const rows = ranking
    .map(({ label, scores }) => ({ label, score: scores[metric] }))
    .sort((a, b) => b.score[0] - a.score[0])
    .map(
      ({ label, score: [mean, from, to] }) =>
        `<tr><th scope="row">${escaped(label)}</th><td class="dots"><span><i class="whisker" style="left:${at(from)};width:calc(${at(to)} - ${at(from)})"></i><i class="dot" style="left:${at(mean)}"></i></span></td><td>${(100 * mean).toFixed(1)} <small>${(100 * from).toFixed(0)}–${(100 * to).toFixed(0)}</small></td></tr>`,
    );
  return `<table class="ranking"><tbody>${rows.join("")}</tbody></table><p class="hint">Percent right in unseen domains, mean over sources; axis ${100 * low} to ${100 * high} %. 95 % intervals over sources and seeds: where they overlap, no order is certain.</p>`;
}

function ours({ rows, targets, origin }, metric) {
  if (!rows.length)
    return '<p class="hint">There are no scores: neither the head’s folder nor the protocol’s records have any.</p>';
  const labels = [...new Set(rows.map((row) => row.label))];
  const shown = (row, target) => {
    const cell = row.cells[target];
    if (!cell) return "<td>–</td>";
    const own = target === row.source;
    return `<td class="heat${own ? " own" : ""}" style="--s:${Math.round(70 * cell[metric])}%" title="${escaped(`${row.source} → ${target}: ACC ${percent(cell[0], 1)}, macro-F1 ${percent(cell[1], 1)}`)}">${(100 * cell[metric]).toFixed(1)}</td>`;
  };
  const body = each(
    labels,
    (label) =>
      each(
        rows.filter((row) => row.label === label),
        (row, i, all) =>
          `<tr>${i ? "" : `<th scope="rowgroup" rowspan="${all.length}">${escaped(label)}<br><small>${row.seeds > 1 ? `${row.seeds} seeds` : "one seed"}</small></th>`}<th scope="row">${escaped(row.source)}</th>${each(targets, (target) => shown(row, target))}<td><b>${(100 * unseen(row, metric)).toFixed(1)}</b></td></tr>`,
      ) +
      overall(
        rows.filter((row) => row.label === label),
        targets,
        metric,
      ),
  );
  const note =
    origin === "protocol"
      ? "Rows of methods are means over seeds of the protocol’s records; rows of heads come from their own <code>metrics.json</code>."
      : "These rows come from the loaded heads’ own <code>metrics.json</code>. There are no records of the whole protocol: <code>python -m omnivat protocol</code> makes them, and <code>app.py --compare DIR</code> adds a head of another source.";
  return `<div><div class="scroll" tabindex="0" role="group" aria-label="Scores from source to target"><table class="counts scores"><thead><tr><th scope="col">Method</th><th scope="col">Source</th>${each(targets, (name) => `<th scope="col">${escaped(name)}</th>`)}<th scope="col">mean of unseen</th></tr></thead><tbody>${body}</tbody></table></div>
    <p class="hint">${note} Percent, on test pairs if the set has a split, else on all pairs. Outlined: the source itself, which is not in the mean.</p></div>`;
}

function papers({ paper, backbone, why, rows }, metric) {
  const sources = [...new Set(rows.map((row) => row.source))].filter((source) =>
    Object.values(paper).some((printed) => printed[source]),
  );
  if (!sources.length) return "";
  const body = Object.entries(paper).map(
    ([method, printed]) =>
      `<tr><th scope="row">${escaped(method)}</th>${each(sources, (source) => `<td>${printed[source] ? printed[source][metric].toFixed(1) : "–"}</td>`)}</tr>`,
  );
  return `<div><div class="scroll" tabindex="0" role="group" aria-label="Figures that the paper prints"><table class="counts paper"><thead><tr><th scope="col">The paper prints, ${escaped(backbone)}</th>${each(sources, (name) => `<th scope="col">${escaped(name.replace(/-sim$/, ""))} → X</th>`)}</tr></thead><tbody>${body.join("")}</tbody></table></div>
    <p class="hint">${why ? `<b class="wrong">Not comparable</b>: ${escaped(why)}. ` : ""}The paper prints means over its targets (X), not single targets.</p></div>`;
}
