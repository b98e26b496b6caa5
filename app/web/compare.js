/** Compare: two maps of the same pairs, linked by pointer, lasso and view. */

import { refused } from "./api.js";
import { thumbnailPair, verdict } from "./card.js";
import { Cloud } from "./cloud.js";
import { CURVES, values } from "./curves.js";
import { shownBy } from "./filters.js";
import { layersOf } from "./layers.js";
import { axes, axisNames, lassoLine, pairLine } from "./marks.js";
import { COLOURINGS, isDark, onTheme } from "./palette.js";
import { listen } from "./pointer.js";
import { STAGES, stageNamed } from "./stages.js";
import { change, state, watch } from "./store.js";
import { escaped, percent } from "./text.js";
import { theSet } from "./theset.js";

const SIDES = [
  { p: "p2", stage: "stage2", name: "left" }, // its own
  { p: "p", stage: "stage", name: "right" }, // that of Explore
];

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  try {
    const { frames, sprite } = await theSet((step) => { $(".wait").textContent = step?.text ? `Computing the map: ${step.text}` : "Computing the map…"; });
    $(".wait").hidden = true;
    compare($, frames, sprite);
  } catch (error) {
    refused(error, (sentence) => {
      $(".wait").classList.add("problem");
      $(".wait").textContent = sentence;
    });
  }
}

function compare($, frames, sprite) {
  const learned = frames.orders[frames.stop(frames.meta.head?.learned_order ?? 0.5)];
  if (state.p === null) state.p = learned;
  if (state.p2 === null) state.p2 = frames.orders[0];
  let shown = shownBy(frames);
  let hovered = -1;
  let selected = new Set();
  let lassoMode = false;
  let changedOnly = false;
  const stopOf = (side) => frames.stop(state[side.p]);

  $(".sides").innerHTML = SIDES.map((side) => sideHtml(side)).join("");
  const parts = SIDES.map((side, i) => {
    const box = $(".sides").children[i];
    const cloud = new Cloud(box.querySelector(".map"), 2 * frames.pairs);
    const part = { side, box, cloud };
    part.drawing = listen(cloud, {
      wanted: (point) => shown(point) && inPlay(point),
      hover, pick, lasso: select, lassoMode: () => lassoMode, current: () => hovered,
      next: (by) => hover((Math.max(hovered, 0) + by + 2 * frames.pairs) % (2 * frames.pairs)),
    });
    cloud.painters = [
      axes(() => axisNames(kind(side))),
      (x, c) => state.pin !== null && pairLine(x, c, state.pin, "#dc2626"),
      (x, c) => hovered >= 0 && pairLine(x, c, hovered % frames.pairs, isDark() ? "#38bdf8" : "#1e293b"),
      (x) => lassoLine(x, part.drawing.polygon),
    ];
    cloud.onView = (view) => parts.forEach((other) => other.cloud !== cloud && other.cloud.setView(view, true));
    box.querySelector(".order").oninput = (event) => change({ [side.p]: frames.orders[frames.stop(+event.target.value)] });
    box.querySelector(".stage").onchange = (event) => change({ [side.stage]: event.target.value });
    return part;
  });

  function sideHtml({ name }) {
    return `<article class="panel side-${name}"><div class="side-bar"><label>Stage <select class="stage">${STAGES.map((s) => `<option value="${s.key}">${s.name}</option>`).join("")}</select></label>
      <label class="grow"><i>p</i> <input type="range" class="order" min="${frames.orders[0]}" max="${frames.orders.at(-1)}" step="0.01" aria-label="p of the ${name} map"></label><output class="order-value"></output></div>
      <div class="map" role="application" aria-label="${name} map"></div><table class="numbers"><tbody></tbody></table></article>`;
  }

  const kind = (side) => (frames.kinds(state[side.stage]).includes(state.map) ? state.map : frames.kinds(state[side.stage])[0]);
  const said = (side, pair) => frames.prediction[stopOf(side) * frames.pairs + pair];
  const changes = (pair) => said(SIDES[0], pair) !== said(SIDES[1], pair);
  const inPlay = (point) => !changedOnly || changes(point % frames.pairs);

  function show() {
    for (const { side, box, cloud } of parts) {
      const stop = stopOf(side);
      box.querySelector(".stage").value = state[side.stage];
      box.querySelector(".order").value = frames.orders[stop];
      box.querySelector(".order-value").textContent = frames.orders[stop].toFixed(2);
      cloud.layers = layersOf(frames, stop, (point) => shown(point) && inPlay(point), (point) => !selected.size || selected.has(point % frames.pairs));
      cloud.show(frames.positions(kind(side), state[side.stage], stop));
      cloud.box.dataset.order = frames.orders[stop];
      box.querySelector("tbody").innerHTML = numbers(side);
    }
    $(".colouring").value = state.colour;
    $(".moved").innerHTML = moved();
    showCard();
  }

  /** The four measures of a side; on the right, how far they are from the left. */
  function numbers(side) {
    return `<tr>${CURVES.map(({ name, title, good }) => {
      const [own, other] = [side, SIDES[0]].map((one) => values(frames, name, state[one.stage])?.[stopOf(one)]);
      const by = own - other;
      const better = Math.abs(by) > 5e-4 && (good === "lower") === by < 0;
      const delta = side !== SIDES[0] && Number.isFinite(by) ? `<small class="${Math.abs(by) < 5e-4 ? "" : better ? "right" : "wrong"}">${by >= 0 ? "+" : "−"}${Math.abs(by).toFixed(3)}</small>` : "";
      return `<td><span>${title}</span><b>${Number.isFinite(own) ? own.toFixed(3) : "–"}</b> ${delta}</td>`;
    }).join("")}</tr>`;
  }

  function moved() {
    let lost = 0;
    let won = 0;
    let other = 0;
    for (let pair = 0; pair < frames.pairs; pair++) {
      if (!changes(pair)) continue;
      if (said(SIDES[0], pair) === frames.label[pair]) lost++;
      else if (said(SIDES[1], pair) === frames.label[pair]) won++;
      else other++;
    }
    const [left, right] = SIDES.map((side) => frames.orders[stopOf(side)].toFixed(2));
    if (left === right) return `Both maps stand at p = ${left}, so the head gives the same answers: move one of them.`;
    return `From p = ${left} to p = ${right}, the head answers <b>${lost + won + other}</b> of ${frames.pairs} pairs otherwise: <span class="right">${won} now right</span>, <span class="wrong">${lost} now wrong</span>, ${other} wrong in another way.`;
  }

  function showCard() {
    const pair = hovered >= 0 ? hovered % frames.pairs : state.pin ?? -1;
    if (pair < 0) {
      $(".card-strip").innerHTML = '<p class="hint">Point at a pair in either map.</p>';
      return;
    }
    const says = SIDES.map((side) => {
      const v = verdict(frames, pair, stopOf(side));
      return `<dt>at p = ${frames.orders[stopOf(side)].toFixed(2)}</dt><dd class="${v.right ? "right" : "wrong"}">${v.right ? "✓" : "✗"} ${escaped(v.said)}, ${percent(v.confidence)}</dd>`;
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
  watch(["p", "p2", "stage", "stage2", "map", "colour"], show);
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
}
