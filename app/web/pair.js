/** Pair: choose two images, read the prediction, move p; all stops come in one answer. */

import { address, ask, json, refused } from "./api.js";
import { thumbnail } from "./card.js";
import { bars, Lines } from "./chart.js";
import { orderBar } from "./order.js";
import { onTheme } from "./palette.js";
import { shelf, somePair } from "./pick.js";
import { sent, slots } from "./slots.js";
import { Spectra } from "./spectrum.js";
import { change, state, watch } from "./store.js";
import { escaped, percent } from "./text.js";
import { theSet } from "./theset.js";

const VOICES = [["both", "both"], ["vis", "VIS"], ["tac", "TAC"]];

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  const none = { frames: null, sprite: null };
  const [examples, set] = await Promise.all([
    json("examples").catch(() => []), theSet().catch(() => none),
  ]);
  pair($, examples, set);
}

/** A scale for the order bar before the server has said where p was learned. */
const scale = (answer) => {
  const orders = answer?.orders ?? Array.from({ length: 101 }, (_, i) => i / 100);
  return { orders, meta: { head: { learned_order: answer?.learned } }, stop: (p) => Math.max(0, Math.min(100, Math.round(100 * p))) };
};

function pair($, examples, set) {
  let answer = null;
  let voice = "both";
  let asking = null;
  let announcing = 0;
  const bar = orderBar($(".order-bar"), scale(null));
  const lines = new Lines($(".lines"), (p) => change({ p }));
  const spectra = new Spectra($(".pictures"));
  const problem = (sentence) => {
    $(".problem").textContent = sentence;
    $(".problem").hidden = !sentence;
  };
  const showSlots = slots($(".slots"), { onRef: (modality, ref) => change({ [modality]: ref }), onProblem: problem });

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
    const image = sent.get(ref);
    return { text: image ? `${image.name} · ${image.width} × ${image.height}` : ref };
  }

  async function answerAgain() {
    showSlots(state, set.sprite, set.frames?.pairs ?? 0, (ref) => known(ref).text);
    showGallery();
    asking?.abort();
    if (!state.vis && !state.tac) return empty();
    asking = new AbortController();
    $(".results").setAttribute("aria-busy", "true");
    const slow = setTimeout(() => { $(".verdict").innerHTML = '<p class="hint">Loading the head… the first answer takes a few seconds, later ones do not.</p>'; }, 300);
    const began = performance.now();
    try {
      answer = await ask("pair", { vis: state.vis, tac: state.tac }, asking.signal);
      answer.took = performance.now() - began;
      problem("");
      showAnswer();
    } catch (error) {
      refused(error, (sentence) => {
        problem(sentence);
        empty();
      });
    } finally {
      clearTimeout(slow);
      $(".results").setAttribute("aria-busy", "false");
    }
  }

  function empty() {
    answer = null;
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
    const at = Object.fromEntries(Object.entries(answer.stops).map(([name, rows]) => [name, rows[stop]]));
    $(".bars").innerHTML = bars(answer.classes, at);
    $(".verdict").innerHTML = verdict(at);
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
    return `<p class="${said === truth ? "right" : "wrong"}">${said === truth ? "✓ right" : `✗ wrong: it is ${escaped(truth)}`}</p>`;
  }

  function showGallery() {
    const used = new Set([state.vis, state.tac]);
    $(".gallery").querySelectorAll("button").forEach((button) => button.setAttribute("aria-pressed", used.has(button.dataset.ref)));
  }

  const offers = shelf(examples, set.frames);
  $(".gallery").innerHTML = offers.length ? offers.map((one) =>
    `<button type="button" data-ref="${escaped(one.ref)}" aria-label="${escaped(`${one.truth}, ${one.domain}`)}"><span>${pictures(one)}</span><small><b>${escaped(one.truth)}</b> ${escaped(one.domain)}</small></button>`).join("")
    : '<p class="hint">No examples are here; upload images, or pin a pair in Explore.</p>';
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
  watch(["p"], showOrder);
  onTheme(() => {
    spectra.paint();
    showOrder();
  });
  if (state.vis || state.tac) answerAgain();
  else somePair(examples, set.frames); // which asks in turn
}
