/** Data & limits: what is loaded, its origin and limits, how to load your own. */

import { ask, Refusal, refused, sendPart } from "../shared/api.js";
import { Scale } from "../shared/chart.js";
import { fit, loaded } from "../shared/facts.js";
import { held } from "../shared/held.js";
import { each, escaped, isSimulated, NO_CLASS, percent, row, table } from "../shared/text.js";
import { theSetSoon } from "../shared/theset.js";
import { tell } from "../shared/view.js";

export async function start(root) {
  const wait = root.querySelector(".wait");
  try {
    const [about, set, { problem }] = await Promise.all([loaded(), theSetSoon(), fit()]);
    const exact = ({ frames }) => {
      root.querySelector(".exact").innerHTML = approximations(frames, about.limits);
    };
    tell(wait, "");
    root.querySelector(".facts").innerHTML = page(about, problem);
    exact(set);
    set.later?.then(exact);
    loading(root.querySelector(".loading"), root.querySelector("template"));
    if (!problem) measuring(root.querySelector(".measuring"));
  } catch (error) {
    refused(error, (sentence) => tell(wait, sentence, true));
  }
}

const counted = (n, one, many = `${one}s`) => `${n} ${n === 1 ? one : many}`;
const panel = (title, body) => `<section class="panel"><h2>${title}</h2>${body}</section>`;
const facts = (rows) =>
  `<dl>${each(
    rows.filter(([, v]) => v !== undefined && v !== ""),
    ([k, v]) => `<dt>${k}</dt><dd>${v}</dd>`,
  )}</dl>`;

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
  const rows = e.domains.map((name, i) =>
    row(escaped(name), [...e.counts[i].map((n) => n || "–"), `<b>${e.counts[i].reduce((a, b) => a + b, 0)}</b>`]),
  );
  const counts = table("Pairs by domain and class", ["Pairs", ...e.classes.map(escaped), "all"], rows, "counts");
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
      ])}${counts}`,
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
  const shown = (v) => (Number.isFinite(v) ? percent(v, 1) : "–");
  const head = ["Measured on", "accuracy", "macro-F1", "photo only", "touch only", "pairs"];
  const rows = domains.map(({ domain, is_source, scores: { fused, vis, tac } = /** @type {any} */ ({}), pairs }) =>
    row(`${escaped(domain)}${is_source ? " <small>source</small>" : ""}`, [
      ...[fused?.accuracy, fused?.macro_f1, vis?.accuracy, tac?.accuracy].map(shown),
      pairs ?? "–",
    ]),
  );
  return `${table("Scores by domain", head, rows, "counts")}<p class="hint">Source: its test pairs if the set has a split; otherwise its training pairs, which mean little. Photo only and touch only: the other image is absent.</p>`;
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

const WIDTH = 420;
const HEIGHT = 120;
const PAD = { left: 40, right: 6, top: 8, bottom: 18 };

/** found: {orders, score, spread, start}; score is the error on source pairs left out. */
export function searched(found) {
  const points = (found?.orders ?? [])
    .map((p, i) => [p, found.score?.[i], found.spread?.[i] ?? 0])
    .filter((point) => point.every(Number.isFinite))
    .sort((a, b) => a[0] - b[0]);
  if (points.length < 2) return "";
  const top = Math.max(...points.map(([, v, s]) => v + s));
  const scale = new Scale({ wide: WIDTH, high: HEIGHT, pad: PAD, ys: [0, top] });
  const bars = each(
    points,
    ([p, v, s]) => `<path d="M${scale.x(p)} ${scale.y(Math.max(0, v - s))}V${scale.y(v + s)}"/>`,
  );
  const best = points.reduce((a, b) => (b[1] < a[1] ? b : a));
  const lowest = `Error against p; lowest, ${best[1].toFixed(2)}, at p = ${best[0].toFixed(2)}`;
  return `<figure class="searched"><figcaption>The search for p: error on pairs of the source that were left out</figcaption>
    <svg viewBox="0 0 ${WIDTH} ${HEIGHT}" role="img" aria-label="${lowest}">${scale.grid([0, top], (v) => v.toFixed(1))}${scale.ticks([0, 0.5, 1].map((p) => [p, p]))}<path class="line" d="${scale.line(points)}"/>${bars}</svg>
    <p class="hint">A classifier at each point; bars are standard errors over pairs. The gradient started from p = ${Number(found.start).toFixed(3)}. ${escaped(found.note ?? "")}</p></figure>`;
}

const figure = (v) =>
  v === 0
    ? "0"
    : v
        .toExponential(1)
        .replace("e", " · 10^")
        .replace(/10\^([+-]?\d+)/, (_, n) => `10<sup>${n.replace("+", "").replace("-", "−")}</sup>`);
const milli = (v) => (v < 10 ? v.toFixed(1) : v.toFixed(0));

export function measuring(box) {
  if (held) {
    box.textContent = held.alone;
    return;
  }
  box.innerHTML = `<div class="row"><button type="button" class="main">Measure now</button><span class="hint" role="status"></span></div><div class="figures"></div>`;
  const button = box.querySelector("button");
  const note = box.querySelector(".hint");
  button.onclick = async () => {
    button.disabled = true;
    note.textContent = "Measuring… about ten seconds; the first time, the head is loaded, too.";
    try {
      box.querySelector(".figures").innerHTML = measuredHtml(await ask("measure", {}));
      note.textContent = "";
      button.textContent = "Measure again";
    } catch (error) {
      refused(error, note);
    } finally {
      button.disabled = false;
    }
  };
}

function measuredHtml({ rows, pairs, width, repeats, threads, processors }) {
  const lines = rows.map(({ what, ms, error, of }) =>
    row(escaped(what), [
      `<b>${milli(ms.median)}</b> <small>${milli(ms.least)} to ${milli(ms.most)}</small>`,
      `${figure(error)}<br><small>${escaped(of)}</small>`,
    ]),
  );
  return `${table("Measured speed and error", ["What", "ms: median, range", "error"], lines, "measured")}
    <p class="hint">${pairs} pairs of this set, D = ${width}, ${threads} ${threads === 1 ? "thread" : "threads"} of ${processors} processors, ${repeats} repeats. The range includes other work on the machine, such as that of other visitors.</p>`;
}

const HEAD = ["weights.safetensors", "settings.json", "metrics.json", "familiarity.safetensors", "profile.safetensors"];
const inUse = () => new URLSearchParams(location.search).get("set");

function loading(box, form) {
  if (held) {
    box.textContent = held.alone;
    return;
  }
  box.append(form.content);
  const note = box.querySelector("[role=status]");
  const button = box.querySelector(".go");
  const back = box.querySelector(".back");
  back.hidden = !inUse();
  back.onclick = () => leave(null);
  button.onclick = async () => {
    button.disabled = true;
    try {
      const files = chosen(box);
      const parts = {};
      for (const [name, file] of Object.entries(files)) {
        note.textContent = `Sending ${name} (${(file.size / 1e6).toFixed(1)} MB)…`;
        parts[name] = await sendPart(name, file);
      }
      note.textContent = "Checking…";
      const { set } = await ask("load", { parts, compare: box.querySelector(".beside").checked });
      leave(set);
    } catch (error) {
      refused(error, note);
    } finally {
      button.disabled = false;
    }
  };
}

/** The files by their names on the server. */
function chosen(box) {
  const found = {};
  for (const file of box.querySelector(".head").files) if (HEAD.includes(file.name)) found[file.name] = file;
  if (box.querySelector(".head").files.length && !found["settings.json"]) {
    throw new Refusal(
      "That folder has no settings.json, so it is not a head. Choose the folder that `omnivat train` wrote.",
    );
  }
  for (const file of box.querySelector(".set").files) {
    const ending = [".thumbnails.webp", ".thumbnails.json", ".safetensors"].find((end) => file.name.endsWith(end));
    if (ending) found[`embeddings${ending}`] = file;
  }
  if (!Object.keys(found).length) throw new Refusal("Choose the folder of a head, an embeddings file, or both.");
  return found;
}

/** Open the page on another set, without the pins and filters of the old one. */
function leave(set) {
  const address = new URL(location.href);
  address.search = "";
  if (set) address.searchParams.set("set", set);
  location.assign(address);
}
