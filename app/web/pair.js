/** Pair: choose two images, read the prediction, move p; all stops come in one answer. */

import { address, ask, json, refused } from "./api.js";
import { thumbnail } from "./card.js";
import { Attention } from "./attention.js";
import { bars, Lines } from "./chart.js";
import { headLabel, heads } from "./headsets.js";
import { nodeMap } from "./nodemap.js";
import { orderBar } from "./order.js";
import { onTheme } from "./palette.js";
import { shelf, somePair } from "./pick.js";
import { sent, slots } from "./slots.js";
import { Spectra } from "./spectrum.js";
import { change, state, watch, watchIn } from "./store.js";
import { escaped, percent } from "./text.js";
import { theSetSoon } from "./theset.js";

const VOICES = [["both", "both"], ["vis", "VIS"], ["tac", "TAC"]];

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  const [examples, set, known] = await Promise.all([
    json("examples").catch(() => []), theSetSoon(), heads().catch(() => []),
  ]);
  const adopt = pair($, examples, set, known.filter((one) => one.name && !one.problem));
  set.later?.then(adopt);
}

/** A scale for the order bar before the server has said where p was learned. */
const scale = (answer) => {
  const orders = answer?.orders ?? Array.from({ length: 101 }, (_, i) => i / 100);
  return { orders, meta: { head: { learned_order: answer?.learned } }, stop: (p) => Math.max(0, Math.min(100, Math.round(100 * p))) };
};

/** Returns what takes the set where it comes late. */
function pair($, examples, first, rivals) {
  let set = first;
  let answer = null;
  let voice = "both";
  let asking = null;
  let announcing = 0;
  let live = null; // the newest answer to a camera's picture
  let others = []; // answers of comparison heads
  const attention = new Attention($(".looks"));
  let onMap = set.frames ? nodeMap($(".on-map"), set.frames, { nodes: false }) : null;
  $(".on-map").hidden = !onMap;
  const bar = orderBar($(".order-bar"), scale(null));
  const lines = new Lines($(".lines"), (p) => change({ p }));
  const spectra = new Spectra($(".pictures"));
  const problem = (sentence) => {
    $(".problem").textContent = sentence;
    $(".problem").hidden = !sentence;
  };
  const showSlots = slots($(".slots"), { onRef: (modality, ref) => change({ [modality]: ref }), onProblem: problem, onLive: showLive,
    liveQuestion: (modality) => ({ modality, other: modality === "vis" ? state.tac : state.vis, order: state.p }) });

  /** What is known of an image by its reference. */
  function known(ref) {
    const [kind, name] = [ref.slice(0, ref.indexOf(":")), ref.slice(ref.indexOf(":") + 1)];
    if (kind === "example") {
      const example = examples.find((one) => one.name === name);
      return { text: example ? `${example.class} · ${example.domain}` : name, truth: example?.class };
    }
    if (kind === "row" && set.frames && +name < set.frames.pairs) {
      const truth = set.frames.classes[set.frames.label[+name]];
      return { text: `pair ${name} · ${truth} · ${set.frames.domains[set.frames.domain[+name]]}`, truth };
    }
    if (kind === "row") return { text: `pair ${name}` };
    const image = sent.get(ref);
    return { text: image ? `${image.name} · ${image.width} × ${image.height}` : ref };
  }

  async function answerAgain() {
    showSlots(state, set.sprite, set.frames?.pairs ?? 0, (ref) => known(ref).text);
    showGallery();
    asking?.abort();
    if (!state.vis && !state.tac) return empty();
    const mine = asking = new AbortController();
    $(".results").setAttribute("aria-busy", "true");
    const slow = setTimeout(() => { $(".verdict").innerHTML = '<p class="hint">Loading the head… the first answer takes a few seconds, later ones do not.</p>'; }, 300);
    const began = performance.now();
    try {
      answer = await ask("pair", { vis: state.vis, tac: state.tac }, mine.signal);
      answer.took = performance.now() - began;
      problem("");
      showAnswer();
      askMore(mine.signal);
    } catch (error) {
      refused(error, (sentence) => {
        problem(sentence);
        empty();
      });
    } finally {
      clearTimeout(slow);
      if (asking === mine) $(".results").setAttribute("aria-busy", "false"); // else the next one still asks
    }
  }

  /** What the first answer need not wait for: other heads, and where attention looks. */
  async function askMore(signal) {
    const question = { vis: state.vis, tac: state.tac };
    onMap?.(question, state.p);
    const quietly = (asked) => asked.catch((error) => {
      if (error.name === "AbortError") throw error;
      return { problem: error.message };
    });
    try {
      const [looks, ...found] = await Promise.all([
        quietly(ask("attention", question, signal)),
        ...rivals.map((one) => quietly(ask("pair", { ...question, head: one.name }, signal))),
      ]);
      others = found.map((one, i) => ({ ...one, label: headLabel(rivals[i]) }));
      attention.show(looks);
      showOrder();
    } catch (error) {
      refused(error, problem);
    }
  }

  /** Every head's answer at this p, side by side. */
  function showRivals(at, stop) {
    $(".rivals").hidden = !others.length;
    if (!others.length) return;
    const top = (row) => row.indexOf(Math.max(...row));
    const cell = (classes, row) => (row ? `<td>${escaped(classes[top(row)])} <b>${percent(Math.max(...row))}</b></td>` : "<td>–</td>");
    const line = (label, classes, rows) => `<tr><th scope="row">${escaped(label)}</th>${VOICES.map(([key]) => cell(classes, rows[key])).join("")}</tr>`;
    $(".rivals").innerHTML = `<header><h3>The same pair, other heads</h3><p class="hint">all at p = ${state.p.toFixed(2)}</p></header><div class="scroll"><table><thead><tr><th scope="col">Head</th>${VOICES.map(([key, name]) => `<th scope="col"><span class="sign ${key}"></span>${name}</th>`).join("")}</tr></thead><tbody>
      ${line("this head", answer.classes, at)}${others.map((one) => (one.problem ? `<tr><th scope="row">${escaped(one.label)}</th><td colspan="3">${escaped(one.problem)}</td></tr>`
        : line(`${one.label} (learned p = ${one.learned.toFixed(3)})`, one.classes, Object.fromEntries(Object.entries(one.stops).map(([name, rows]) => [name, rows[stop]]))))).join("")}</tbody></table></div>`;
  }

  /** A camera's newest answer takes the verdict and the bars; null gives them back. */
  function showLive(found) {
    const was = live;
    live = found;
    if (!found) return was ? answerAgain() : undefined;
    const at = found.probabilities;
    const best = at.both.indexOf(Math.max(...at.both));
    $(".bars").innerHTML = bars(found.classes, at);
    $(".verdict").innerHTML = `<div class="said"><h2>${escaped(found.classes[best])} <span>${percent(at.both[best], 1)}</span></h2><p><b class="tag">live</b></p></div><p class="hint">${Number.isFinite(found.fps) ? `${found.fps.toFixed(1)} pictures answered in a second` : "counting…"}; curves, spectra and map below are of the pair chosen before.</p>`;
  }

  function empty() {
    clearTimeout(announcing);
    answer = null;
    others = [];
    showRivals();
    attention.show(null);
    $(".verdict").innerHTML = '<p class="hint">Choose a pair to see what the head says: one of the two images is enough.</p>';
    $(".bars").innerHTML = $(".lines").innerHTML = $(".pictures").innerHTML = "";
    spectra.all = [];
  }

  function showAnswer() {
    if (state.p === null) state.p = Math.round(100 * Math.max(0, Math.min(1, answer.learned))) / 100;
    if (!answer.stops[voice]) voice = "both";
    bar.replace(scale(answer));
    bar.learned(answer.learned);
    $(".which").innerHTML = VOICES.filter(([key]) => answer.stops[key]).map(([key, name]) =>
      `<button type="button" role="radio" data-voice="${key}" aria-checked="${key === voice}">${name}</button>`).join("");
    lines.show(answer.classes, answer.orders, answer.stops[voice], answer.learned);
    spectra.show(answer.spectra);
    showOrder();
  }

  function showOrder() {
    if (state.p === null) return;
    const stop = scale(answer).stop(state.p);
    bar.show(stop);
    if (!answer) return;
    attention.mark(stop);
    const at = Object.fromEntries(Object.entries(answer.stops).map(([name, rows]) => [name, rows[stop]]));
    showRivals(at, stop);
    if (!live) {
      $(".bars").innerHTML = bars(answer.classes, at);
      $(".verdict").innerHTML = verdict(at);
    }
    lines.mark(stop, answer.orders);
    spectra.mark(stop);
    clearTimeout(announcing);
    announcing = setTimeout(() => { $(".sr").textContent = spoken(at); }, 400);
  }

  /** What a screen reader says once p has settled. */
  function spoken(at) {
    const best = at.both.indexOf(Math.max(...at.both));
    return `p ${state.p.toFixed(2)}: ${answer.classes[best]}, ${percent(at.both[best], 1)}`;
  }

  function verdict(at) {
    const top = (row) => row.indexOf(Math.max(...row));
    const says = (name) => `${escaped(answer.classes[top(at[name])])} <b>${percent(Math.max(...at[name]))}</b>`;
    const truths = { vis: state.vis && known(state.vis).truth, tac: state.tac && known(state.tac).truth };
    const said = answer.classes[top(at.both)];
    const exact = answer.exact.both;
    return `<div class="said"><h2>${escaped(said)} <span>${percent(Math.max(...at.both), 1)}</span></h2>${judged(said, truths)}</div>
      <p>${at.vis ? `<span class="sign vis"></span> VIS alone: ${says("vis")}` : ""} ${at.tac ? `<span class="sign tac"></span> TAC alone: ${says("tac")}` : ""}</p>
      <p class="hint">At the learned p = ${answer.learned.toFixed(4)}: ${escaped(answer.classes[top(exact)])} ${percent(Math.max(...exact), 1)} · 101 exact stops answered together in ${Math.round(answer.took)} ms</p>`;
  }

  function judged(said, { vis, tac }) {
    if (vis && tac && vis !== tac) {
      const winner = said === vis ? "VIS wins" : said === tac ? "TAC wins" : "neither wins";
      return `<p>VIS is of <b>${escaped(vis)}</b>, TAC of <b>${escaped(tac)}</b>: <b>${winner}</b>.</p>`;
    }
    const truth = vis ?? tac;
    if (!truth) return "";
    return `<p class="${said === truth ? "right" : "wrong"}">${said === truth ? "✓ right" : `✗ wrong: it is ${escaped(truth)}${answer.classes.includes(truth) ? "" : ", a class that this head never learned"}`}</p>`;
  }

  function showGallery() {
    const used = new Set([state.vis, state.tac]);
    $(".gallery").querySelectorAll("button").forEach((button) => button.setAttribute("aria-pressed", used.has(button.dataset.ref)));
  }

  function fillGallery() {
    const offers = shelf(examples, set.frames);
    $(".gallery").innerHTML = offers.length ? offers.map((one) =>
      `<button type="button" data-ref="${escaped(one.ref)}" aria-label="${escaped(`${one.truth}, ${one.domain}`)}"><span>${pictures(one)}</span><small><b>${escaped(one.truth)}</b> ${escaped(one.domain)}</small></button>`).join("")
      : `<p class="hint">${set.frames ? "No examples are here; upload images, or pin a pair in Explore." : "The set’s pairs come with its map, which is being computed; your own images are answered now."}</p>`;
    showGallery();
  }

  /** The set has come after the first answer: its pictures, its pairs to pick, its map. */
  function adopt(late) {
    set = late;
    onMap = nodeMap($(".on-map"), set.frames, { nodes: false });
    $(".on-map").hidden = false;
    fillGallery();
    showSlots(state, set.sprite, set.frames.pairs, (ref) => known(ref).text);
    if (answer) {
      showOrder();
      onMap({ vis: state.vis, tac: state.tac }, state.p);
    }
    somePair(examples, set.frames);
  }

  fillGallery();
  $(".gallery").onclick = (event) => {
    const button = event.target.closest("button");
    if (!button) return;
    const { ref } = button.dataset;
    const take = $(".take").value;
    change(take === "both" ? { vis: ref, tac: ref } : { [take]: ref });
  };

  function pictures({ path, pair: row }) {
    if (path === undefined) {
      return ["VIS", "TAC"].map((label, i) => thumbnail(set.sprite, row + i * set.frames.pairs, 48, label)).join("");
    }
    const coded = path.split("/").map(encodeURIComponent).join("/");
    return ["vis", "tac"].map((modality) => `<img loading="lazy" alt="" src="${address(`example/${coded}/${modality}`)}">`).join("");
  }
  $(".which").onclick = (event) => {
    const button = event.target.closest("button");
    if (!button || !answer) return;
    voice = button.dataset.voice;
    showAnswer();
  };
  watch(["vis", "tac"], answerAgain);
  watchIn("pair", ["p"], () => {
    showOrder();
    if (answer) onMap?.({ vis: state.vis, tac: state.tac }, state.p);
  });
  watch(["view"], () => $(".slots").querySelectorAll(".slot").forEach((slot) => slot.quiet()));
  onTheme(() => {
    spectra.paint();
    attention.paint();
    showOrder();
  });
  if (state.vis || state.tac) answerAgain();
  else somePair(examples, set.frames); // which asks in turn
  if (!state.vis && !state.tac) empty();
  return adopt;
}
