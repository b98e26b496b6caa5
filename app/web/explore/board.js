/** What Explore shows of a set: its parts, drawn from the scene and the address, and what visitors do on the map. */

import { ask, attempt, inSet } from "../shared/api.js";
import { card, spoken } from "../shared/card.js";
import { showFilters } from "../shared/filters.js";
import { orderText } from "../shared/frames.js";
import { ACCURACY, asText, GAPS, values } from "../shared/measures.js";
import { orderBar } from "../shared/order.js";
import { colouring } from "../shared/palette.js";
import { afterwards } from "../shared/ready.js";
import { explained, featuresOf, OUTPUT, stageNamed, stepsOf } from "../shared/stages.js";
import { can, modeOf } from "../shared/tables.js";
import { press } from "../shared/view.js";
import * as beside from "./beside.js";
import { featuresHtml, headOf, LESSONS, rightAt, whence } from "./chapters.js";
import * as curves from "./curves.js";
import * as finder from "./finder.js";
import * as gaps from "./gaps.js";
import { showGrid, showNeighbours } from "./grid.js";
import * as maps from "./maps.js";
import { modeWords } from "./modes.js";
import * as nodes from "./nodes.js";
import { openPanel, panelIsOpen, rememberPanels } from "./panels.js";
import { listen, peek } from "./pictures.js";
import { $, change, fill, html, joined, put, scene, send, showWords, state } from "./root.js";
import { labelCsv } from "./saving.js";
import { isDouble, nearKey, nearStage, nextPoint, packed, painted, unpacked } from "./scene.js";
import { showSteps } from "./staircase.js";
import * as strangers from "./strangers.js";
import * as toy from "./toy.js";

/** @type {ReturnType<typeof orderBar>} */
let bar;
/** What draws them. @type {Record<"ride" | "curves", () => void>} */
let charts;
/** @type {Pointing} */
const pointing = {
  wanted: maps.shown,
  hover: (point) => hover(point, true),
  pick: (point) => pick(point),
  lasso: (points) => select(points),
  next: (by) => {
    hover(nextPoint(scene, by));
    announcePairSoon();
  },
  lassoMode: () => scene.lasso,
  current: () => scene.hovered,
};

/** Make the bar that moves p, which stands there before the set does. */
export const buildBar = () => (bar = orderBar($(".order-bar")));

/** Make the parts with the first set. */
export function build() {
  if (maps.map) return;
  maps.build(pointing);
  listen();
  gaps.listen(() => {
    maps.showNow();
    gaps.show();
    announceSoon();
  });
  finder.listen();
  rememberPanels(() => {
    showToy();
    nodes.follow();
  });
  charts = { ride: curves.accuracy(), curves: curves.features() };
}

/** Show facts about the set or its head that have come. */
export function learned() {
  strangers.show();
  showColours();
  showLesson();
  if (scene.facts.unseen && state.cell) followCell();
  if (state.chapter === "gaps") gaps.follow();
  showPictures();
}

/** Open a chapter: nothing is selected, the whole map is in view. @param {Frames} frames */
export function start(frames) {
  send("started", frames);
  resetMaps();
  replace(frames);
  if (state.chapter === "gaps") gaps.open();
  followSelection();
}

/** Select the points in the address, if others are selected. */
export function followSelection() {
  if (state.sel === packed(scene.selected)) return;
  select(unpacked(state.sel, 2 * scene.frames.pairs).filter(maps.shown));
}

/** Show the whole map, or both. */
export function resetMaps() {
  maps.reset();
  beside.follow(pointing);
}

let waiting = 0; // the animation frame in which what has come is drawn

/** Draw a map's next stop, or values of the pairs, that have come. */
function arrived() {
  cancelAnimationFrame(waiting);
  waiting = requestAnimationFrame(() => {
    if (!scene.chapter || !maps.map) return;
    if (scene.frames.confidence.length !== scene.confident) {
      send("arrived", { confident: scene.frames.confidence.length });
      showColours();
      showCard();
    }
    maps.showNow();
    beside.show();
  });
}

/** Show other frames of the same pairs. @param {Frames} frames */
export function replace(frames) {
  frames.arrivals.add(arrived);
  send("replaced", frames);
  bar.replace(frames);
  bar.learned(state.chapter === "analyse" ? scene.own.learned : NaN); // the mark would give the answer away
  fill($(".mode-words"), modeWords(frames));
  Object.assign($().dataset, { kind: frames.kind, can: modeOf(frames).can.join(" ") });
  $(".ride").classList.toggle("blind", !values(frames, ACCURACY, OUTPUT)?.some(Number.isFinite));
  showColours();
  showStage();
  showMeans();
}

/** p has moved. */
export function showOrder() {
  const { frames, stop } = send("moved", {});
  bar.show(stop);
  showCurves();
  showSteps();
  if (state.chapter === "gaps") gaps.show();
  showToy();
  nodes.follow();
  if (state.chapter === "order") toy.showWave(frames.orders[stop]);
  if (can(colouring(painted(scene, state), state.colour), "order")) maps.showLayers();
  maps.showNow();
  beside.show();
  showCard();
  showLesson();
  announceSoon();
}

/** Show the words and figures of a chapter; in the workbench, the accuracy and whose it is. */
function showLesson() {
  const { frames, stop, facts } = scene;
  const lesson = LESSONS[state.chapter];
  if (state.chapter === "gaps") gaps.tell();
  else if (lesson?.words) showWords(lesson.words(scene));
  else
    fill(
      $(".stage .score"),
      frames.headless ? featuresHtml(scene) : html`${headOf(frames, stop)}${whence(frames, stop, facts.unseen)}`,
    );
}

/** Show the chosen step: its words, its kinds of map, and the map. */
export function showStage() {
  const { frames } = scene;
  const steps = stepsOf(frames).map(({ id }) => id);
  if (!steps.includes(state.stage))
    return change({ stage: steps.find((id) => id === featuresOf(state.stage)) ?? steps[0] }); // it lacks a projection
  const stage = stageNamed(state.stage);
  fill($(".explain"), html`<b>${stage.title}.</b> ${explained(stage, frames)}`);
  maps.showKinds();
  return showOrder();
}

function showCurves() {
  if (state.chapter === "gaps") return;
  charts.ride();
  charts.curves();
}

/** Show the colourings and the filters, and apply them. */
export function showColours() {
  maps.showColourings();
  showFilters($(".filters"), painted(scene, state), (/** @type {Scene["highlight"]} */ highlight) => {
    send("arrived", { highlight });
    showPoints();
  });
  refilter();
}

function showPoints() {
  maps.showLayers();
  beside.show();
}

/** Apply the filters everywhere: maps, titles, curves, selection, what is saved. */
export function refilter() {
  const before = scene.selected.size;
  send("filtered", {});
  if (before !== scene.selected.size) change({ sel: packed(scene.selected) });
  maps.showLayers();
  if (maps.map.frame) maps.showNow();
  beside.show();
  showCurves();
  finder.show();
  showPictures();
}

/** Select points, and keep them in the address. @param {number[]} points */
export function select(points) {
  send("selected", points);
  change({ sel: packed(points) });
  showPoints();
  showPictures();
  if (points.length) openPanel("grid");
}

/** Show and list the pairs of the cell of the confusion matrix in the address; all pairs without one. */
export function followCell() {
  if (!scene.facts.unseen) return;
  send("cellFollowed", {});
  strangers.showConfusion();
  refilter();
  if (!scene.cell) return; // the selection in the address stays
  select([...scene.cell.pairs].flatMap((pair) => [pair, pair + scene.frames.pairs]).filter(maps.shown));
}

/** Show another reading: no cell is chosen, and the map has the points and predictions of this one. */
export function showReading() {
  if (scene.cell) change({ cell: "", sel: "" });
  strangers.show();
  refilter();
  showLesson();
}

const showToy = () => panelIsOpen("toy") && toy.show(scene.frames.orders[scene.stop]);

/** Show the card of the pair under the pointer, or of the pinned one. */
export function showCard() {
  const { sprite, hovered, stop, sample, facts } = scene;
  const frames = painted(scene, state);
  const pair = hovered >= 0 ? hovered % frames.pairs : (state.pin ?? -1);
  const pinned = pair >= 0 && pair === state.pin;
  $('[data-panel="card"]').hidden = state.chapter === "gaps" || (state.chapter !== "analyse" && state.pin === null);
  put($(".card"), card(frames, sprite, pair, stop, pinned, sample, facts.pairs));
  if (pinned) showNeighbours();
}

/** Highlight a point, -1 for none. @param {number} point
 * @param {boolean} pointed true if the pointer chose it: its pictures then appear beside the pointer */
function hover(point, pointed = false) {
  if (point === scene.hovered) return;
  send("arrived", { hovered: point });
  maps.map.marks.style.cursor = point >= 0 ? "pointer" : scene.lasso ? "crosshair" : "grab";
  paintMarks();
  showCard();
  peek(point < 0 ? -1 : point % scene.frames.pairs, pointed);
}

/** Pin the pair of a point, for the other tabs too if it is of their set, and find its neighbours.
 * @param {number} point */
export function pick(point) {
  send("arrived", { nearest: null });
  if (point < 0) return change({ pin: null });
  const { pairs } = scene.frames;
  const pin = point % pairs;
  change({ pin, ...(scene.set ? {} : { vis: `row:${pin}`, tac: `row:${pin}` }) });
  return findNear(point < pairs ? 0 : 1);
}

/** Find the neighbours of the pinned pair's photo, 0, or touch, 1. @param {number} half */
export async function findNear(half) {
  const { set, frames, stop } = scene;
  const key = nearKey(scene, state);
  const box = $(".card .found") ?? {}; // no card is on the screen
  box.textContent = "Computing this stage for the whole set…";
  await attempt(async () => {
    const point = Number(state.pin) + frames.pairs * half;
    const question = { point, stage: nearStage(scene, state), order: frames.orders[stop] };
    const { neighbours } = await ask(inSet("neighbours", set), question);
    if (key !== nearKey(scene, state)) return;
    send("arrived", { nearest: { key, points: neighbours } });
    showNeighbours();
    paintMarks();
  }, box);
}

export function showMeans() {
  press($(".tool.means"), state.means === "1");
  press($(".tool.second"), isDouble(scene, state));
  paintMarks();
}

/** Draw what is above the points. */
export function paintMarks() {
  maps.map.paintMarks();
  beside.paintMarks();
}

/** Show the pictures of what is selected or found. */
function showPictures() {
  showGrid();
  labelCsv();
}

/** Speak of the pair that the keys came to or pinned. */
export const announcePairSoon = afterwards(() => {
  const { hovered, stop, own } = scene;
  const pair = hovered >= 0 ? hovered % own.pairs : state.pin;
  $(".announcement").textContent =
    pair === null ? "No pair is pinned" : spoken(painted(scene, state), pair, stop, pair === state.pin);
}, 200);

/** What p changes, spoken once it rests. */
const announceSoon = afterwards(() => {
  if (state.chapter === "gaps") return gaps.announce();
  const { frames, stop } = scene;
  const spokenGaps = GAPS.map(({ id, title }) => {
    const gap = values(frames, id, featuresOf(state.stage))?.[stop];
    return Number.isFinite(gap) && `${title.toLowerCase()} ${asText(id, gap)}`;
  });
  const right = rightAt(frames, stop);
  $(".announcement").textContent = joined([
    `p ${orderText(frames.orders[stop])}`,
    ...spokenGaps,
    Number.isFinite(right) && `accuracy on unseen domains ${asText(ACCURACY, right)}`,
  ]);
}, 400);
