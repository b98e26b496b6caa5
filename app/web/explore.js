/** Explore: the slider, the curves and the map, answered in the browser stop by stop. */

import { json, refused } from "./api.js";
import { beforeMap, title } from "./before.js";
import { card } from "./card.js";
import { Cloud } from "./cloud.js";
import { coach } from "./coach.js";
import { Curves, values } from "./curves.js";
import { csv, download, png, svg } from "./exports.js";
import { whenFine } from "./frames.js";
import { showFilters, shownBy } from "./filters.js";
import { layersOf } from "./layers.js";
import { axes, axisNames, lassoLine, neighbourRings, pairLine } from "./marks.js";
import { means } from "./means.js";
import { findNeighbours } from "./neighbours.js";
import { orderBar } from "./order.js";
import { COLOURINGS, isDark, onTheme } from "./palette.js";
import { listen } from "./pointer.js";
import { showSelection } from "./selection.js";
import { stageButtons, stageNamed } from "./stages.js";
import { change, hidden, state, watch, watchIn } from "./store.js";
import { openTab } from "./tabs.js";
import { percent } from "./text.js";
import { theSet } from "./theset.js";

const MAPS = { pca: "PCA", umap: "UMAP" };

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  const wait = $(".wait");
  try {
    const telling = (step) => { wait.textContent = waiting(step); };
    const { frames, coarse, sprite } = await theSet(telling);
    wait.hidden = true;
    root.querySelector(".explore").classList.add("ready");
    const page = explore($, frames, sprite);
    if (!coarse) return;
    wait.hidden = false;
    page.replace(await whenFine(telling));
    wait.hidden = true;
  } catch (error) {
    refused(error, (sentence) => {
      wait.hidden = false;
      wait.classList.add("problem");
      wait.textContent = sentence;
    });
  }
}

function waiting(step) {
  if (!step) return "Computing the map…";
  const share = step.total ? ` · ${step.done} of ${step.total}` : "";
  return `Computing the map: ${step.text || "working"}${share}. Eleven stops come first, then all; the tabs open with the first.`;
}

function explore($, first, sprite) {
  let frames = first;
  let stop = 0;
  let hovered = -1;
  let near = [];
  let selected = new Set();
  let highlight = null;
  let lassoMode = false;
  let shown = shownBy(frames);
  let announcing = 0;
  let retrained = [];
  const sample = frames.label.findIndex((label, pair) => label === frames.prediction[frames.stop(frames.meta.head?.learned_order ?? 0.5) * frames.pairs + pair]);

  const cloud = new Cloud($(".map"), 2 * frames.pairs);
  let curves = new Curves($(".curves"), frames, (p) => change({ p: +p.toFixed(2) }));
  const showStages = stageButtons($(".stages"), () => state.stage, (stage) => change({ stage }));
  const bar = orderBar($(".order-bar"), frames);
  const listening = {
    wanted: (point) => shown(point),
    hover, pick, lasso: select, next,
    lassoMode: () => lassoMode,
    current: () => hovered,
  };
  const drawing = listen(cloud, listening);
  const painters = [
    means(() => frames, (point) => shown(point)),
    (x, c) => neighbourRings(x, c, near),
    (x, c) => state.pin !== null && pairLine(x, c, state.pin, "#dc2626"),
    (x, c) => hovered >= 0 && hovered % frames.pairs !== state.pin
      && pairLine(x, c, hovered % frames.pairs, isDark() ? "#38bdf8" : "#1e293b"),
  ];
  const before = beforeMap($(".still"), frames, { ...listening, lassoMode: () => false }, painters);
  cloud.painters = [axes(() => axisNames(state.map)), ...painters, (x) => lassoLine(x, drawing.polygon)];
  const paintMarks = () => [cloud, before].forEach((one) => one.paintMarks());

  // ---- what is shown ----------------------------------------------------------------------

  const lit = (point) => {
    if (highlight) {
      const pair = point % frames.pairs;
      const own = { domain: frames.domains[frames.domain[pair]], class: frames.classes[frames.label[pair]], modality: point < frames.pairs ? "VIS" : "TAC" };
      return own[highlight.kind] === highlight.name;
    }
    return !selected.size || selected.has(point);
  };

  function showMap() {
    const frame = frames.positions(state.map, state.stage, stop);
    cloud.show(frame);
    cloud.box.dataset.order = frames.orders[frame.drawn];
    $(".approximate").textContent = approximate(frames, frame, stop);
    return frame;
  }

  function showLayers() {
    cloud.layers = before.layers = layersOf(frames, stop, shown, lit);
    cloud.redraw();
    before.redraw();
  }

  function showOrder() {
    stop = frames.stop(state.p);
    bar.show(stop);
    curves.mark(stop);
    if (["correctness", "confidence"].includes(state.colour)) showLayers();
    showMap();
    showCard();
    $(".now .map-title").innerHTML = title(frames, state.stage, stop, `${stageNamed(state.stage).name}, p = ${frames.orders[stop].toFixed(2)}`);
    clearTimeout(announcing);
    announcing = setTimeout(announce, 400);
  }

  function showStage() {
    showStages();
    const stage = stageNamed(state.stage);
    $(".explain").innerHTML = `<b>${stage.name}.</b> ${stage.explain}${state.stage === "frft" && projected(frames) ? " (This head first projects E to fewer numbers: hence another map than E’s, but it stands as still.)" : ""}`;
    const kinds = frames.kinds(state.stage);
    if (!kinds.includes(state.map) && kinds.length) change({ map: kinds[0] });
    $(".map-kind").innerHTML = kinds.map((k) => `<option value="${k}">${MAPS[k] ?? k}</option>`).join("");
    $(".map-kind").value = state.map;
    near = [];
    $(".maps").classList.toggle("alone", ["raw", "frft"].includes(state.stage) || !frames.kinds("raw").includes("pca"));
    $(".before .map-title").innerHTML = title(frames, "raw", 0, 'Before: raw<span class="long"> embedding</span>');
    if (frames.kinds("raw").includes("pca")) before.show(frames.positions("pca", "raw", 0));
    showCurves();
    showOrder();
  }

  /** Where one domain alone is shown, its own curves. */
  function showCurves() {
    const left = frames.domains.filter((name) => !hidden("domain").has(name));
    curves.show(state.stage, left.length === 1 ? left[0] : "");
    curves.mark(stop);
  }

  function showColours() {
    $(".colouring").value = state.colour;
    shown = shownBy(frames);
    showFilters($(".filters"), frames, (name) => {
      highlight = name;
      showLayers();
    });
    showLayers();
    showCurves();
  }

  function showCard() {
    const pair = hovered >= 0 ? hovered % frames.pairs : state.pin ?? -1;
    $(".card").innerHTML = card(frames, sprite, pair, stop, pair >= 0 && pair === state.pin, sample);
  }

  function announce() {
    const gap = values(frames, "modality_gap", state.stage);
    const accuracy = values(frames, "accuracy", state.stage);
    const parts = [`p ${frames.orders[stop].toFixed(2)}`];
    if (gap) parts.push(`modality gap ${gap[stop].toFixed(3)}`);
    if (accuracy) parts.push(`accuracy ${percent(accuracy[stop], 1)}`);
    $(".sr").textContent = parts.join(", ");
  }

  // ---- what a visitor does ----------------------------------------------------------------

  function hover(point) {
    if (point === hovered) return;
    hovered = point;
    cloud.marks.style.cursor = point >= 0 ? "pointer" : lassoMode ? "crosshair" : "grab";
    paintMarks();
    showCard();
  }

  function pick(point) {
    near = [];
    if (point < 0) return change({ pin: null });
    const pair = point % frames.pairs;
    change({ pin: pair, vis: `row:${pair}`, tac: `row:${pair}` });
  }

  function next(by) {
    const total = 2 * frames.pairs;
    for (let i = 1; i <= total; i++) {
      const point = (Math.max(hovered, -1) + by * i + total * 2) % total;
      if (shown(point)) return hover(point);
    }
  }

  function select(points) {
    selected = new Set(points);
    showLayers();
    showSelection($(".selection"), { frames, sprite, points, stop, onPick: pick, onClear: () => select([]), onSave: () => save("csv") });
  }

  const about = () => ({ stage: state.stage, kind: state.map });
  const legend = () => COLOURINGS[state.colour].groups(frames);
  const caption = () => `OmniVaT · ${stageNamed(state.stage).name} · p = ${frames.orders[stop].toFixed(2)} · ${MAPS[state.map]} · ${frames.meta.embeddings.simulated ? "simulated data" : frames.meta.embeddings.origin} · ● VIS ▲ TAC`;

  async function save(kind) {
    const name = `omnivat-${state.stage}-p${frames.orders[stop].toFixed(2)}`;
    const all = Array.from({ length: 2 * frames.pairs }, (_, i) => i).filter((i) => shown(i));
    if (kind === "csv") download(`${name}.csv`, csv(frames, selected.size ? [...selected] : all, cloud.frame, stop, about()));
    if (kind === "png") download(`${name}.png`, await png(cloud, caption(), legend()));
    if (kind === "svg") download(`${name}.svg`, svg(cloud, caption(), legend(), axisNames(state.map)));
    if (kind === "link") $(".sr").textContent = await copied(location.href);
    $(".save").open = false;
  }

  // ---- wiring -----------------------------------------------------------------------------

  $(".colouring").innerHTML = Object.entries(COLOURINGS).map(([key, c]) => `<option value="${key}">${c.label}</option>`).join("");
  $(".colouring").onchange = (event) => change({ colour: event.target.value });
  $(".map-kind").onchange = (event) => change({ map: event.target.value });
  $(".in").onclick = () => cloud.zoomBy(1.4);
  $(".out").onclick = () => cloud.zoomBy(1 / 1.4);
  $(".reset").onclick = () => cloud.resetView();
  $(".lasso").onclick = () => {
    lassoMode = !lassoMode;
    $(".lasso").setAttribute("aria-pressed", lassoMode);
  };
  $(".menu").onclick = (event) => event.target.dataset.save && save(event.target.dataset.save);
  $(".card").onclick = async (event) => {
    if (event.target.matches(".open")) openTab("pair");
    if (event.target.matches(".unpin")) pick(-1);
    if (event.target.matches(".find")) {
      near = await findNeighbours($(".card .found"), { frames, sprite, point: state.pin + frames.pairs * event.target.dataset.of, stage: state.stage, p: frames.orders[stop], onPick: pick });
      paintMarks();
    }
  };
  watchIn("explore", ["p"], showOrder);
  watch(["stage"], showStage);
  watch(["map"], () => { $(".map-kind").value = state.map; showMap(); });
  watch(["colour", "domain", "class", "modality"], showColours);
  watch(["pin"], () => { showCard(); paintMarks(); });
  watch(["means"], showMeans);
  $(".tool.means").onclick = () => change({ means: state.means === "1" ? "0" : "1" });
  onTheme(() => [cloud, before].forEach((one) => one.redraw()));
  json("retrained").then(({ points }) => { curves.retrained(points); retrained = points; }).catch(() => {});

  function showMeans() {
    $(".tool.means").setAttribute("aria-pressed", state.means === "1");
    paintMarks();
  }

  function replace(finer) {
    frames = finer;
    shown = shownBy(frames);
    bar.replace(frames);
    curves = new Curves($(".curves"), frames, (p) => change({ p: +p.toFixed(2) }));
    curves.retrained(retrained);
    showColours();
    showStage();
  }

  if (state.p === null) state.p = frames.orders[frames.stop(frames.meta.head?.learned_order ?? 0.5)];
  if (state.pin !== null && !(state.pin < frames.pairs)) state.pin = null;
  if (!COLOURINGS[state.colour]) state.colour = "domain";
  stop = frames.stop(state.p);
  showColours();
  showStage();
  showMeans();
  coach($(".order-bar"));
  return { replace };
}

/** Copy a text; say what to do where the browser does not let a page copy. */
async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
    return "Link copied.";
  } catch {
    return "Copy the address from the address bar.";
  }
}

const projected = ({ meta: { maps } }) => maps["pca/raw"]?.array !== maps["pca/frft"]?.array;

function approximate(frames, frame, stop) {
  const parts = [];
  if (frame.stops === 1) parts.push("one map for every p: exact, because the transform is unitary");
  else if (frame.drawn !== stop) parts.push(`this map has ${frame.stops} stops: drawn at p = ${frames.orders[frame.drawn].toFixed(2)}`);
  else parts.push(`exact frame for p = ${frames.orders[stop].toFixed(2)}, nothing is tweened`);
  if (frame.error !== undefined) parts.push(`rounding to 16 bits moves a point by at most ${(100 * frame.error).toPrecision(1)} % of the radius`);
  if (state.map === "umap") parts.push("UMAP is a layout: neighbourhoods mean something, distances and axes do not");
  if (["f_bar", "f_hat"].includes(state.stage)) parts.push("the class-token bank stays that of the learned p while p moves");
  return parts.join(" · ");
}
