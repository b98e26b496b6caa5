/** Data & limits: what is loaded, its origin and limits, how to load your own. */

import { json, refused } from "../shared/api.js";
import { fit } from "../shared/facts.js";
import { held } from "../shared/held.js";
import { escaped, isSimulated, NO_CLASS, percent } from "../shared/text.js";
import { theSetSoon } from "../shared/theset.js";
import { loading } from "./loading.js";
import { measuring } from "./measuring.js";
import { searched } from "./search.js";

export async function start(root) {
  const wait = root.querySelector(".wait");
  try {
    const [about, set, { problem }] = await Promise.all([json("about"), theSetSoon(), fit()]);
    const exact = ({ frames }) => {
      root.querySelector(".exact").innerHTML = approximations(frames, about.limits);
    };
    wait.hidden = true;
    root.querySelector(".facts").innerHTML = page(about, problem);
    exact(set);
    set.later?.then(exact);
    loading(root.querySelector(".loading"));
    if (!problem) measuring(root.querySelector(".measuring"));
  } catch (error) {
    refused(error, (sentence) => {
      wait.classList.add("problem");
      wait.textContent = sentence;
    });
  }
}

const counted = (n, one, many = `${one}s`) => `${n} ${n === 1 ? one : many}`;
const panel = (title, body) => `<section class="panel"><h2>${title}</h2>${body}</section>`;
const facts = (rows) =>
  `<dl>${rows
    .filter(([, v]) => v !== undefined && v !== "")
    .map(([k, v]) => `<dt>${k}</dt><dd>${v}</dd>`)
    .join("")}</dl>`;

function page({ head, embeddings }, unfit) {
  return [
    panel("The set", embeddings.problem ? refusal(embeddings) : theData(embeddings)),
    panel("The head", unfit || head.problem ? refusal({ problem: unfit || head.problem }) : theHead(head)),
    panel("Limits", '<div class="exact"></div>'),
    panel("Your own head and pairs", '<div class="loading"></div>'),
    unfit ? "" : panel("Speed and error here", '<div class="measuring"></div>'),
  ].join("");
}

const refusal = ({ problem: sentence }) => `<p class="wait problem">${escaped(sentence)}</p>`;

const more = (title, body) => `<details><summary>${title}</summary>${body}</details>`;

function theData(e) {
  const head = `<tr><th scope="col">Pairs</th>${e.classes.map((name) => `<th scope="col">${escaped(name)}</th>`).join("")}<th scope="col">all</th></tr>`;
  const rows = e.domains.map(
    (name, i) =>
      `<tr><th scope="row">${escaped(name)}</th>${e.counts[i].map((n) => `<td>${n || "–"}</td>`).join("")}<td><b>${e.counts[i].reduce((a, b) => a + b, 0)}</b></td></tr>`,
  );
  const simulated = e.simulated || e.domains.some(isSimulated);
  return `${simulated ? `<p class="note"><b>Simulated</b> by this project: no figure is about real sensors.</p>` : '<p class="note real"><b>Real pairs</b>, according to the file’s header.</p>'}
    ${facts([
      [
        "Pairs",
        `${e.pairs.toLocaleString("en-US")} in ${counted(e.domains.length, "domain")}, ${e.classes.join() === NO_CLASS ? "no classes" : counted(e.classes.length, "class", "classes")}`,
      ],
      ["Encoder", escaped(e.encoder)],
    ])}
    ${more(
      "Domains, classes, origin",
      `${facts([
        ["File", escaped(e.name)],
        ["Origin", escaped(e.origin)],
        ["Embeddings", `${e.width} numbers for each image; weights ${escaped(e.weights_hash.slice(0, 12))}`],
        ["Preprocessing", escaped(e.preprocessing)],
      ])}<div class="scroll" tabindex="0" aria-label="Pairs by domain and class"><table class="counts"><thead>${head}</thead><tbody>${rows.join("")}</tbody></table></div>`,
    )}`;
}

function theHead(h) {
  const { source, ...rest } = h.provenance;
  const record = escaped(JSON.stringify({ provenance: rest, metrics: h.metrics }, null, 2).slice(0, 20000));
  return `${facts([
    ["Trained on", source && `<b>${escaped(source)}</b> only`],
    ["Learned p", h.order.toFixed(4)],
    ["Size", `${(h.parameters / 1e6).toFixed(2)} M parameters, D = ${h.width}`],
  ])}
    ${more("Scores by domain", scores(h.metrics) + searched(h.metrics.order_search))}
    ${more(
      "Its record",
      `${facts([
        ["Folder", escaped(h.name)],
        ["Tokens, levels", `E = ${h.expansion}, R = ${h.levels}`],
        ["Classes", escaped(h.classes.join(", "))],
        ["Encoder", escaped(h.encoder.name)],
      ])}<pre tabindex="0">${record}</pre>`,
    )}`;
}

/** The scores of each domain from `metrics.json`. */
function scores({ domains }) {
  if (!Array.isArray(domains) || !domains.length) return "";
  const cell = (v) => `<td>${Number.isFinite(v) ? percent(v, 1) : "–"}</td>`;
  const rows = domains.map(
    (d) =>
      `<tr><th scope="row">${escaped(d.domain)}${d.is_source ? " <small>source</small>" : ""}</th>${cell(d.scores?.fused?.accuracy)}${cell(d.scores?.fused?.macro_f1)}${cell(d.scores?.vis?.accuracy)}${cell(d.scores?.tac?.accuracy)}<td>${d.pairs ?? "–"}</td></tr>`,
  );
  return `<div class="scroll" tabindex="0" role="group" aria-label="Scores by domain"><table class="counts"><thead><tr><th scope="col">Measured on</th><th scope="col">accuracy</th><th scope="col">macro-F1</th><th scope="col">photo only</th><th scope="col">touch only</th><th scope="col">pairs</th></tr></thead><tbody>${rows.join("")}</tbody></table></div><p class="hint">Source: its test pairs if the set has a split; otherwise its training pairs, which mean little. Photo only and touch only: the other image is absent.</p>`;
}

function approximations(frames, limits) {
  const error =
    frames && Math.max(...Object.keys(frames.meta.maps).map((name) => frames.positions(...name.split("/"), 0).error));
  const ofHead = `<li>Each stop of p is exact; lines between are not.</li>
    <li>Accuracy is on pairs outside the training.</li>
    <li>Probabilities are calibrated on the source, overconfident elsewhere.</li>`;
  return `<ul>${frames?.headless ? "" : ofHead}
    ${frames ? `<li>Map positions are at most ${percent(error, 3)} of the radius off.</li>` : ""}
    <li>Images up to ${limits.image_bytes / 1e6} MB; ${held ? "they stay in this browser" : "the server keeps their embeddings alone"}.</li></ul>`;
}
