/** Scores from each source to each target, and the paper's figures. */

import { attempt, json } from "../shared/api.js";
import { radios } from "../shared/radios.js";
import { each, escaped, percent, row, table } from "../shared/text.js";

const METRICS = ["ACC", "macro-F1"];
const score = (v) => (100 * v).toFixed(1);
const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length; // NaN for none

export function matrix(box) {
  box.innerHTML = `<header><h3>Methods, <span class="metric"></span></h3><div class="which" role="radiogroup" aria-label="Which score"></div></header>
    <div class="ranked"></div><details class="every"><summary>Every source and target, and the paper’s figures</summary><div class="two-tables"></div></details>`;
  const ranked = box.querySelector(".ranked");
  return attempt(async () => {
    const found = await json("matrix");
    let metric = 0;
    const show = () => {
      mark();
      box.querySelector(".metric").textContent = METRICS[metric];
      ranked.innerHTML = dots(found.ranking, metric);
      box.querySelector(".two-tables").innerHTML = ours(found, metric) + papers(found, metric);
    };
    const mark = radios(
      box.querySelector(".which"),
      METRICS.map((label, key) => ({ key: String(key), label })),
      () => String(metric),
      (key) => {
        metric = +key;
        show();
      },
    );
    show();
  }, ranked);
}

/** The mean over targets without the source. */
const unseen = ({ cells, source }, metric) =>
  mean(Object.entries(cells).flatMap(([target, cell]) => (target === source ? [] : [cell[metric]])));

/** The methods in order: a dot and its 95 % interval each, on one axis. */
export function dots(ranking, metric) {
  if (ranking.length < 2) return "";
  const all = ranking.map(({ scores }) => scores[metric]);
  const low = Math.floor(20 * Math.min(...all.map((one) => one[1]))) / 20;
  const high = Math.ceil(20 * Math.max(...all.map((one) => one[2]))) / 20;
  const at = (v) => `${((100 * (v - low)) / (high - low)).toFixed(2)}%`;
  const sorted = ranking.toSorted((a, b) => b.scores[metric][0] - a.scores[metric][0]);
  const rows = each(sorted, ({ label, scores }) => {
    const [middle, from, to] = scores[metric];
    const drawn = `<span><i class="whisker" style="left:${at(from)};width:calc(${at(to)} - ${at(from)})"></i><i class="dot" style="left:${at(middle)}"></i></span>`;
    const figures = `${score(middle)} <small>${(100 * from).toFixed(0)}–${(100 * to).toFixed(0)}</small>`;
    return row(escaped(label), [`<td class="dots">${drawn}</td>`, figures]);
  });
  return `<table class="ranking"><tbody>${rows}</tbody></table><p class="hint">Percent right in unseen domains, mean over sources; axis ${100 * low} to ${100 * high} %. 95 % intervals over sources and seeds: where they overlap, no order is certain.</p>`;
}

function ours({ rows, targets, origin }, metric) {
  if (!rows.length)
    return '<p class="hint">There are no scores: neither the head’s folder nor the protocol’s records have any.</p>';
  const cell = ({ source, cells }, target) => {
    const both = cells[target];
    if (!both) return "–";
    const words = `${source} → ${target}: ACC ${percent(both[0], 1)}, macro-F1 ${percent(both[1], 1)}`;
    return `<td class="heat${target === source ? " own" : ""}" style="--s:${Math.round(70 * both[metric])}%" title="${escaped(words)}">${score(both[metric])}</td>`;
  };
  const lines = Object.entries(Object.groupBy(rows, ({ label }) => label)).flatMap(([label, own = []]) => {
    const name = `<th scope="rowgroup" rowspan="${own.length}">${escaped(label)}<br><small>${own[0].seeds > 1 ? `${own[0].seeds} seeds` : "one seed"}</small></th>`;
    const means = own.map((one) => unseen(one, metric));
    const body = own.map((one, i) => {
      const line = row(escaped(one.source), [
        ...targets.map((target) => cell(one, target)),
        `<b>${score(means[i])}</b>`,
      ]);
      return i ? line : line.replace("<tr>", `<tr>${name}`);
    });
    const overall = `<tr class="overall"><th scope="row" colspan="2">mean of ${own.length} sources</th><td colspan="${targets.length}"></td><td><b>${score(mean(means))}</b></td></tr>`;
    return own.length > 1 ? [...body, overall] : body;
  });
  const note =
    origin === "protocol"
      ? "Rows of methods are means over seeds of the protocol’s records; rows of heads come from their own <code>metrics.json</code>."
      : "These rows come from the loaded heads’ own <code>metrics.json</code>. There are no records of the whole protocol: <code>python -m omnivat protocol</code> makes them, and <code>app.py --compare DIR</code> adds a head of another source.";
  return `<div>${table("Scores from source to target", ["Method", "Source", ...targets.map(escaped), "mean of unseen"], lines, "counts scores")}
    <p class="hint">${note} Percent, on test pairs if the set has a split, else on all pairs. Outlined: the source itself, which is not in the mean.</p></div>`;
}

function papers({ paper, backbone, why, rows }, metric) {
  const printed = Object.entries(paper);
  const known = [...new Set(rows.map(({ source }) => source))].filter((source) =>
    printed.some(([, own]) => own[source]),
  );
  if (!known.length) return "";
  const body = printed.map(([method, own]) =>
    row(
      escaped(method),
      known.map((source) => own[source]?.[metric].toFixed(1) ?? "–"),
    ),
  );
  const head = [
    `The paper prints, ${escaped(backbone)}`,
    ...known.map((name) => `${escaped(name.replace(/-sim$/, ""))} → X`),
  ];
  return `<div>${table("Figures that the paper prints", head, body, "counts paper")}
    <p class="hint">${why ? `<b class="wrong">Not comparable</b>: ${escaped(why)}. ` : ""}The paper prints means over its targets (X), not single targets.</p></div>`;
}
