/** Data & limits: what is loaded, its origin and limits, how to load your own. */

import { json, refused } from "../shared/api.js";
import { escaped, isSignals, isSimulated, percent } from "../shared/text.js";
import { theSetSoon } from "../shared/theset.js";
import { loading } from "./loading.js";
import { measuring } from "./measuring.js";
import { searched } from "./search.js";
import { ABOUT, glossary, OWN } from "./words.js";

export async function start(root) {
  const wait = root.querySelector(".wait");
  try {
    const [about, set] = await Promise.all([json("about"), theSetSoon()]);
    const exact = ({ frames }) => {
      root.querySelector(".exact").innerHTML = approximations(frames, about.limits);
    };
    wait.hidden = true;
    root.querySelector(".facts").innerHTML = page(about);
    exact(set);
    set.later?.then(exact);
    loading(root.querySelector(".loading"));
    measuring(root.querySelector(".measuring"));
  } catch (error) {
    refused(error, (sentence) => {
      wait.classList.add("problem");
      wait.textContent = sentence;
    });
  }
}

const panel = (title, body) => `<section class="panel"><h2>${title}</h2>${body}</section>`;
const facts = (rows) =>
  `<dl>${rows
    .filter(([, v]) => v !== undefined && v !== "")
    .map(([k, v]) => `<dt>${k}</dt><dd>${v}</dd>`)
    .join("")}</dl>`;

function page({ head, embeddings, examples }) {
  return [
    panel("The set", embeddings.problem ? problem(embeddings) : theData(embeddings, examples)),
    panel("The head", head.problem ? problem(head) : theHead(head)),
    panel("Measured on this machine", '<div class="measuring"></div>'),
    panel("Limits of the figures", ABOUT(embeddings.simulated, isSignals(embeddings))),
    panel("What is exact and what is not", '<div class="exact"></div>'),
    panel("Your own head and pairs", `<div class="loading"></div>${OWN}`),
    panel("Words", glossary()),
  ].join("");
}

const problem = ({ problem: sentence }) => `<p class="wait problem">${escaped(sentence)}</p>`;

function theData(e, examples) {
  const head = `<tr><th scope="col">Pairs</th>${e.classes.map((name) => `<th scope="col">${escaped(name)}</th>`).join("")}<th scope="col">all</th></tr>`;
  const rows = e.domains.map(
    (name, i) =>
      `<tr><th scope="row">${escaped(name)}</th>${e.counts[i].map((n) => `<td>${n || "–"}</td>`).join("")}<td><b>${e.counts[i].reduce((a, b) => a + b, 0)}</b></td></tr>`,
  );
  return `${e.simulated || e.domains.some(isSimulated) ? `<p class="note"><b>Simulated.</b> ${isSignals(e) ? "This project computed these signals. A pair is two recordings of one signal; the page calls the first “photo” and the second “touch”." : "This project rendered the photos and touch images. They stand in for the data sets whose names end in “-sim” here."} No figure is a result on real sensors.</p>` : '<p class="note real"><b>Real pairs</b>, according to the file’s header.</p>'}
    ${facts([
      ["File", escaped(e.name)],
      ["Origin", escaped(e.origin)],
      ["Pairs", e.pairs],
      [
        "Encoder",
        `${escaped(e.encoder)}, ${e.width} numbers for each image, weights ${escaped(e.weights_hash.slice(0, 12))}`,
      ],
      ["Preprocessing", escaped(e.preprocessing)],
      ["Examples to pick", examples || ""],
    ])}
    <div class="scroll" tabindex="0" aria-label="Pairs by domain and class"><table class="counts"><thead>${head}</thead><tbody>${rows.join("")}</tbody></table></div>`;
}

function theHead(h) {
  const { source, ...rest } = h.provenance;
  return `${facts([
    ["Folder", escaped(h.name)],
    ["Trained on", source && `<b>${escaped(source)}</b> only. All other domains are unseen`],
    ["Learned p", h.order.toFixed(4)],
    ["Classes", escaped(h.classes.join(", "))],
    [
      "Size",
      `${(h.parameters / 1e6).toFixed(2)} M parameters; D = ${h.width}, E = ${h.expansion}, ${h.levels} tree levels`,
    ],
    ["Encoder", escaped(h.encoder.name)],
  ])}
    ${scores(h.metrics)}${searched(h.metrics.order_search)}
    <details><summary>The whole record of its folder</summary><pre tabindex="0">${escaped(JSON.stringify({ provenance: rest, metrics: h.metrics }, null, 2).slice(0, 20000))}</pre></details>`;
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
    frames &&
    Math.max(...Object.keys(frames.meta.maps).map((name) => frames.positions(...name.split("/"), 0).error));
  return `<ul><li>Every stop of p is computed exactly. Nothing is interpolated: between two stops, features do not move along straight lines.</li>
    ${frames ? `<li>Map positions have 16 bits: a point is at most ${percent(error, 3)} of the radius from its exact place.</li>` : ""}
    <li>PCA is computed anew at every p, then turned or mirrored to follow the map before it. UMAP is a layout: neighbourhoods mean something, distances and axes do not.</li>
    <li>Weights stay fixed while p moves, except in the mode “Trained here”, where each stop is a separate head.</li>
    <li>Nearest neighbours use the exact cosine in full width, not the map.</li>
    <li>Probabilities use a temperature fitted to held-out pairs of the source. In other domains they are still overconfident. Familiarity compares an image with its nearest training image in the encoder’s space.</li>
    <li>Images up to ${limits.image_bytes / 1e6} MB and ${limits.image_pixels / 1e6} megapixels are accepted. The server keeps their embeddings while it runs, never the images. Nothing leaves this machine.</li></ul>`;
}
