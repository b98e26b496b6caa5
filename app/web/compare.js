/** Compare: two maps of the same pairs, linked by pointer, lasso and view. */

import { Refusal, refused } from "./api.js";
import { thumbnailPair, verdict } from "./card.js";
import { Cloud } from "./cloud.js";
import { CURVES, values } from "./curves.js";
import { shownBy } from "./filters.js";
import { framesBy, headLabel, heads, isMethod, METHODS } from "./headsets.js";
import { layersOf } from "./layers.js";
import { axes, axisNames, lassoLine, pairLine } from "./marks.js";
import { matrix } from "./matrix.js";
import { means } from "./means.js";
import { COLOURINGS, isDark, onTheme } from "./palette.js";
import { listen } from "./pointer.js";
import { STAGES, stageNamed } from "./stages.js";
import { change, state, watch, watchIn } from "./store.js";
import { escaped, percent } from "./text.js";
import { theSet } from "./theset.js";

const SIDES = [
  { p: "p2", stage: "stage2", head: "head2", only: "only2", name: "left" }, // its own
  { p: "p", stage: "stage", head: "head", only: "only", name: "right" }, // p and stage of Explore
];

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  try {
    const { frames, sprite } = await theSet((step) => { $(".wait").textContent = step?.text ? `Computing the map: ${step.text}` : "Computing the map…"; });
    $(".wait").hidden = true;
    compare($, frames, sprite, await heads().catch(() => []));
    matrix($(".matrix"));
  } catch (error) {
    refused(error, (sentence) => {
      $(".wait").classList.add("problem");
      $(".wait").textContent = sentence;
    });
  }
}

function compare($, frames, sprite, known) {
  const learned = frames.orders[frames.stop(frames.meta.head?.learned_order ?? 0.5)];
  if (state.p === null) state.p = learned;
  if (state.p2 === null) state.p2 = frames.orders[0];
  let shown = shownBy(frames);
  let hovered = -1;
  let selected = new Set();
  let lassoed = new Set(); // classes of what is selected
  let lassoMode = false;
  let changedOnly = false;
  const by = new Map(SIDES.map((side) => [side, frames])); // whose frames a side shows
  const stopOf = (side) => by.get(side).stop(state[side.p]);
  const inDomain = (side, pair) => !state[side.only] || frames.domains[frames.domain[pair]] === state[side.only];
  const apart = () => state.only && state.only2 && state.only !== state.only2;

  $(".sides").innerHTML = SIDES.map((side) => sideHtml(side)).join("");
  const parts = SIDES.map((side, i) => {
    const box = $(".sides").children[i];
    const cloud = new Cloud(box.querySelector(".map"), 2 * frames.pairs);
    const part = { side, box, cloud };
    part.drawing = listen(cloud, {
      wanted: (point) => shown(point) && inPlay(point) && inDomain(side, point % frames.pairs),
      hover, pick, lasso: select, lassoMode: () => lassoMode, current: () => hovered,
      next: (by) => hover((Math.max(hovered, 0) + by + 2 * frames.pairs) % (2 * frames.pairs)),
    });
    cloud.painters = [
      axes(() => axisNames(kind(side))),
      means(() => frames, (point) => shown(point) && inPlay(point) && inDomain(side, point % frames.pairs)),
      (x, c) => state.pin !== null && inDomain(side, state.pin) && pairLine(x, c, state.pin, "#dc2626"),
      (x, c) => hovered >= 0 && inDomain(side, hovered % frames.pairs) && pairLine(x, c, hovered % frames.pairs, isDark() ? "#38bdf8" : "#1e293b"),
      (x) => lassoLine(x, part.drawing.polygon),
    ];
    cloud.onView = (view) => parts.forEach((other) => other.cloud !== cloud && other.cloud.setView(view, true));
    box.querySelector(".order").oninput = (event) => change({ [side.p]: by.get(side).orders[by.get(side).stop(+event.target.value)] });
    for (const name of ["stage", "head", "only"]) {
      box.querySelector(`.${name}`).onchange = (event) => change({ [side[name]]: event.target.value });
    }
    return part;
  });

  function sideHtml({ name }) {
    return `<article class="panel side-${name}"><div class="side-bar"><label>Answers by <select class="head">${[["", known[0] ? headLabel(known[0]) : "the head"], ...known.slice(1).map((one) => [one.name, headLabel(one)]), ...METHODS].map(([value, label]) => `<option value="${escaped(value)}">${escaped(label)}</option>`).join("")}</select></label>
      <label>Domain <select class="only"><option value="">all</option>${frames.domains.map((d) => `<option>${escaped(d)}</option>`).join("")}</select></label></div>
      <div class="side-bar"><label>Stage <select class="stage">${STAGES.map((s) => `<option value="${s.key}">${s.name}</option>`).join("")}</select></label>
      <label class="grow"><i>p</i> <input type="range" class="order" min="${frames.orders[0]}" max="${frames.orders.at(-1)}" step="0.01" aria-label="p of the ${name} map"></label><output class="order-value"></output></div><p class="side-wait hint" role="status" hidden></p>
      <div class="map" role="application" aria-label="${name} map"></div><table class="numbers"><tbody></tbody></table></article>`;
  }

  const kind = (side) => (by.get(side).kinds(state[side.stage]).includes(state.map) ? state.map : by.get(side).kinds(state[side.stage])[0]);
  const said = (side, pair) => by.get(side).classes[by.get(side).prediction[stopOf(side) * frames.pairs + pair]];
  const truth = (pair) => frames.classes[frames.label[pair]];
  const changes = (pair) => said(SIDES[0], pair) !== said(SIDES[1], pair);
  const inPlay = (point) => !changedOnly || changes(point % frames.pairs);

  function show() {
    for (const { side, box, cloud } of parts) {
      const stop = stopOf(side);
      const own = by.get(side);
      box.querySelector(".stage").value = state[side.stage];
      box.querySelector(".head").value = state[side.head];
      box.querySelector(".only").value = state[side.only];
      box.querySelector(".order").value = own.orders[stop];
      box.querySelector(".order-value").textContent = own.orders[stop].toFixed(2);
      cloud.layers = layersOf(own, stop, (point) => shown(point) && inPlay(point) && inDomain(side, point % frames.pairs), (point) => lit(point % frames.pairs));
      cloud.show(own.positions(kind(side), state[side.stage], stop));
      cloud.box.dataset.order = own.orders[stop];
      box.querySelector("tbody").innerHTML = numbers(side);
    }
    $(".colouring").value = state.colour;
    $(".moved").innerHTML = moved();
    showCard();
  }

  /** The four measures of a side; on the right, how far they are from the left. */
  function numbers(side) {
    return `<tr>${CURVES.map(({ name, title, good }) => {
      const [own, other] = [side, SIDES[0]].map((one) => values(by.get(one), name, state[one.stage], ["modality_gap", "accuracy"].includes(name) ? state[one.only] : "")?.[stopOf(one)]);
      const none = state[side.only] && !["modality_gap", "accuracy"].includes(name);
      const off = own - other;
      const better = Math.abs(off) > 5e-4 && (good === "lower") === off < 0;
      const delta = side !== SIDES[0] && Number.isFinite(off) ? `<small class="${Math.abs(off) < 5e-4 ? "" : better ? "right" : "wrong"}">${off >= 0 ? "+" : "−"}${Math.abs(off).toFixed(3)}</small>` : "";
      return `<td><span>${title}</span><b>${Number.isFinite(own) && !none ? own.toFixed(3) : "–"}</b> ${none ? "" : delta}</td>`;
    }).join("")}</tr>`;
  }

  function moved() {
    if (apart()) return `${escaped(state.only2)} and ${escaped(state.only)} share no pairs: a lasso in one lights the same classes in the other.`;
    const only = state.only || state.only2;
    let all = 0;
    let lost = 0;
    let won = 0;
    let other = 0;
    for (let pair = 0; pair < frames.pairs; pair++) {
      if (only && frames.domains[frames.domain[pair]] !== only) continue;
      all++;
      if (!changes(pair)) continue;
      if (said(SIDES[0], pair) === truth(pair)) lost++;
      else if (said(SIDES[1], pair) === truth(pair)) won++;
      else other++;
    }
    const [left, right] = SIDES.map((side) => (isMethod(state[side.head]) ? "nearest class mean" : `${state[side.head] || "the head"} at p = ${by.get(side).orders[stopOf(side)].toFixed(2)}`));
    if (left === right) return `Both sides show ${escaped(left)}, which gives the same answers: move one of them.`;
    return `From ${escaped(left)} (left) to ${escaped(right)} (right), <b>${lost + won + other}</b> of ${all} pairs are answered otherwise: <span class="right">${won} now right</span>, <span class="wrong">${lost} now wrong</span>, ${other} wrong in another way.`;
  }

  const lit = (pair) => !selected.size || selected.has(pair) || (apart() && lassoed.has(frames.label[pair]));

  /** Fetch the frames of who answers on each side; the head's own stay until they are there. */
  async function loadBoth() {
    await Promise.all(SIDES.map(async (side, i) => {
      const wait = parts[i].box.querySelector(".side-wait");
      const name = state[side.head];
      const tell = (step) => {
        wait.hidden = false;
        wait.textContent = step?.text ? `Computing this head’s map: ${step.text}${step.total ? `, ${step.done} of ${step.total}` : ""}` : "Computing…";
      };
      if (name) tell(null);
      try {
        const found = await framesBy(name, frames, tell, loadBoth);
        if (state[side.head] !== name) return;
        if (found.pairs !== frames.pairs) throw new Refusal("This head’s map is of another set.");
        by.set(side, found);
        wait.hidden = true;
        const range = parts[i].box.querySelector(".order");
        range.disabled = isMethod(name);
      } catch (error) {
        refused(error, (sentence) => {
          wait.hidden = false;
          wait.textContent = sentence;
        });
      }
    }));
    show();
  }

  function showCard() {
    const pair = hovered >= 0 ? hovered % frames.pairs : state.pin ?? -1;
    if (pair < 0) {
      $(".card-strip").innerHTML = `${thumbnailPair(frames, sprite, 0, 84)}<p class="hint">Point at a pair in either map: its photo and touch stand here, with what each side says of it.</p>`;
      return;
    }
    const says = SIDES.map((side) => {
      const v = verdict(by.get(side), pair, stopOf(side));
      return `<dt>${side.name}${isMethod(state[side.head]) ? "" : `, p = ${by.get(side).orders[stopOf(side)].toFixed(2)}`}</dt><dd class="${v.right ? "right" : "wrong"}">${v.right ? "✓" : "✗"} ${escaped(v.said)}, ${percent(v.confidence)}</dd>`;
    });
    const v = verdict(frames, pair, 0);
    $(".card-strip").innerHTML = `${thumbnailPair(frames, sprite, pair, 84)}<div><h3>Pair ${pair}</h3><dl><dt>${escaped(v.domain)}</dt><dd>${escaped(v.truth)}</dd>${says.join("")}</dl></div>`;
  }

  const marks = () => parts.forEach(({ cloud }) => cloud.paintMarks());

  function hover(point) {
    if (point === hovered) return;
    hovered = point;
    marks();
    showCard();
  }

  function pick(point) {
    if (point < 0) return change({ pin: null });
    const pair = point % frames.pairs;
    change({ pin: pair, vis: `row:${pair}`, tac: `row:${pair}` });
  }

  /** A lasso catches whole pairs, so that both of their points stay lit on both sides. */
  function select(points) {
    selected = new Set(points.map((point) => point % frames.pairs));
    lassoed = new Set([...selected].map((pair) => frames.label[pair]));
    show();
  }

  const pressed = (selector, on) => $(selector).setAttribute("aria-pressed", on);
  $(".colouring").innerHTML = Object.entries(COLOURINGS).map(([key, c]) => `<option value="${key}">${c.label}</option>`).join("");
  $(".colouring").onchange = (event) => change({ colour: event.target.value });
  $(".reset").onclick = () => parts[0].cloud.resetView();
  $(".lasso").onclick = () => pressed(".lasso", (lassoMode = !lassoMode));
  $(".changed").onclick = () => {
    pressed(".changed", (changedOnly = !changedOnly));
    show();
  };
  watchIn("compare", ["p", "p2", "stage", "stage2", "map", "colour", "only", "only2"], show);
  watch(["head", "head2"], loadBoth);
  watch(["domain", "class", "modality"], () => {
    shown = shownBy(frames);
    show();
  });
  watch(["pin"], () => {
    marks();
    showCard();
  });
  onTheme(show);
  state.stage2 = stageNamed(state.stage2).key;
  show();
  loadBoth();
}
