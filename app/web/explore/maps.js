/** The map of the open step. */

import { halvesOf } from "../shared/card.js";
import { Cloud } from "../shared/cloud.js";
import { orderText } from "../shared/frames.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames, lassoLine, neighbourRings, pairLine, shapes } from "../shared/marks.js";
import { means, names } from "../shared/means.js";
import { asText, GAPS, values } from "../shared/measures.js";
import { colouring, colouringsOf, isDark } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { INPUT, isStill, stageNamed } from "../shared/stages.js";
import { can, modeOf, sensorOf } from "../shared/tables.js";
import { gapLines, pairOnMap, withPair } from "./gap-marks.js";
import { pictures } from "./pictures.js";
import { $, choice, html, joined, options, percent, put, scene, state } from "./root.js";
import { filtering, isDouble, lit, loneDomain, near, painted } from "./scene.js";

/** @type {Record<string, string>} */
export const METHODS = { pca: "PCA", umap: "UMAP" };
const GLIDE = 140; // milliseconds from one stop to the next
const PALE = 0.75;
const TOOLS = 46; // CSS pixels that the tools of the workbench cover at the top of the map

/** @type {Cloud} */
export let map;
/** Return whether a point is drawn. @type {Wanted} */
export const shown = (point) => scene.mask[point] === 1;
/** @type {Wanted} */
const isLit = (point) => lit(scene, point);

/** Draw the lines of the pinned pair and of the pair under the pointer. @type {Painter} */
export function pairLines(x, cloud) {
  const { pairs } = scene.frames;
  const halves = halvesOf(scene.frames);
  const pair = scene.hovered % pairs;
  const places = (/** @type {number} */ pair) => [pair, pair + pairs].map((point) => cloud.place(point));
  if (state.pin !== null) pairLine(x, cloud, places(state.pin), "#dc2626", halves);
  if (scene.hovered >= 0 && pair !== state.pin)
    pairLine(x, cloud, places(pair), isDark() ? "#38bdf8" : "#1e293b", halves);
}

/** Make the map. @param {Pointing} on */
export function build(on) {
  map = new Cloud($(".now .map"), 2 * scene.own.pairs);
  const drawing = listen(map, on);
  const colours = () => painted(scene, state);
  const named = names(colours, shown);
  const scaled = axes(() => axisNames(kindOf(state.stage)));
  /** @param {Painter} paint @returns {Painter} */
  const ofGaps = (paint) => (x, cloud) => state.chapter === "gaps" && paint(x, cloud);
  map.painters = [
    ofGaps(gapLines(shown)),
    (x, cloud) =>
      state.chapter !== "gaps" &&
      (state.chapter === "analyse" ? scaled(x, cloud) : shapes(x, cloud, shapeWords(scene.frames))),
    pictures,
    (x, cloud) =>
      neighbourRings(
        x,
        cloud,
        near(scene, state).map(({ point }) => point),
      ),
    (x, cloud) => state.chapter !== "gaps" && pairLines(x, cloud),
    ofGaps(pairOnMap(kindOf)),
    (x, cloud) => cloud.view.zoom < 3 && state.chapter !== "gaps" && named(x, cloud),
    means(colours, shown), // above the names
    (x) => lassoLine(x, drawing.polygon),
  ];
}

/** Prepare for another set or chapter: make room for its points, with the whole map in view. */
export function reset() {
  const over = getComputedStyle($(".tools")).position === "absolute"; // on a phone they stand above the map
  map.top = ["gaps", "analyse"].includes(state.chapter) && over && !isDouble(scene, state) ? TOOLS : 0;
  if (map.count !== 2 * scene.own.pairs) map.hold(2 * scene.own.pairs);
  map.resetView();
}

/** Return the method of a map: the chosen one if the step has it. @param {string} stage */
export function kindOf(stage, frames = scene.frames) {
  const kinds = frames.kinds(stage);
  return kinds.includes(state.map) ? state.map : kinds[0];
}

/** Show the choice between the kinds of map that the open step has. */
export const showKinds = () =>
  choice(
    ".kinds",
    "map",
    scene.frames.kinds(state.stage).map((key) => ({ key, label: METHODS[key] ?? key })),
    kindOf(state.stage),
  );

/** Show the colourings that the frames have. */
export function showColourings() {
  const frames = painted(scene, state);
  const rows = colouringsOf(frames).map(({ id, title }) => [id, title]);
  put($(".colouring"), options(rows, colouring(frames, state.colour).id));
}

/** Show the points of frames at a stop, by colour. @param {Cloud} cloud */
export const showLayers = (cloud = map, frames = scene.frames, stop = scene.stop) => {
  cloud.halves = [0, frames.pairs].map((from) => scene.mask.subarray(from, from + frames.pairs).includes(1));
  cloud.layers = layersOf(painted(scene, state, frames), stop, shown, isLit);
  if (state.chapter === "gaps") for (const { style } of cloud.layers) style.alpha *= PALE; // lines and stars stand out
  cloud.redraw();
};

/** Draw the open step at the present stop. */
export function showNow() {
  const { frames, stop } = scene;
  const kind = kindOf(state.stage);
  if (!kind) return;
  const frame = frames.positions(kind, state.stage, stop);
  $(".map-wait").hidden = Boolean(frame);
  if (!frame) return;
  if (state.chapter === "gaps") map.glide(withPair(frame, kind), GLIDE);
  else map.show(frame);
  map.box.dataset.order = String(frames.orders[isStill(state.stage, frames) ? stop : frame.drawn]);
  $(".approximate").textContent = notes(frames, frame, stop, kind);
  put($('[data-panel="step"] .map-title'), title(kind));
}

/** Return a measure of frames at a stop, with its words; null if not measured.
 * @type {(words: string, measure: string, values: number[] | null | undefined, stop: number) => Html | null} */
export const figure = (words, measure, values, stop) =>
  Number.isFinite(values?.[stop])
    ? html`<span class="gap">${words} <b>${asText(measure, values?.[stop], 2)}</b></span>`
    : null;

/** Return figures of both gaps at a stop; of one domain, of its modality gap alone.
 * @param {Frames} frames
 * @param {string} stage
 * @param {number} stop */
export function gaps(frames, stage, stop, domain = "") {
  const rows = GAPS.filter((row) => !domain || can(row, "domain"));
  return rows.map(({ id, title }, i) => {
    const words = `${title.toLowerCase()}${domain && ` in ${sensorOf(domain)}`}`;
    return [i > 0 && " ", figure(words, id, values(frames, id, stage, domain), stop)];
  });
}

/** Return the title of the map: its step, its method, and the gaps of the points shown. @param {string} kind */
function title(kind) {
  const { frames, stop } = scene;
  const domain = loneDomain(scene, state);
  const hides = filtering(scene, state);
  const partly = hides.length && !(domain && hides.length === 1);
  return html`<span class="where-at">${stageNamed(state.stage).title}, p = ${orderText(frames.orders[stop])} <small>
    ${METHODS[kind] ?? kind}</small></span>${gaps(frames, state.stage, stop, domain)}${
      partly
        ? html`<span>${hides.join(" · ")}. The gaps are those of ${domain ? "the whole domain" : "all pairs"}.</span>`
        : null
    }`;
}

/** @type {(frames: Frames) => string} */
export const shapeWords = ({ signals }) => (signals ? "● one recording  ▲ the other" : "● photo  ▲ touch");

/** Return what to know about the map: how far its neighbours can be trusted, and which stop it shows.
 * @param {Frames} frames @param {NonNullable<ReturnType<Frames["positions"]>>} frame @param {number} stop
 * @param {string} kind */
function notes(frames, { trust, stops, drawn }, stop, kind) {
  const analysed = state.chapter === "analyse" && !isDouble(scene, state); // two maps leave no room
  const still = isStill(state.stage, frames);
  const words = [
    analysed &&
      Number.isFinite(trust) &&
      `${percent(trust ?? 0)} of neighbours here are true neighbours (trust ${trust?.toFixed(2)}).`,
    kind !== state.map && `This step has no ${METHODS[state.map]} map.`,
    stops > 1 &&
      drawn !== stop &&
      `The map shows p = ${orderText(frames.orders[drawn])}, the nearest of ${stops} stops.`,
    analysed &&
      still &&
      stops === 1 &&
      state.stage !== INPUT &&
      "The map is the same at every p, because the transform changes no distance.",
    analysed && !still && modeOf(frames).note,
    analysed && kind === "umap" && "Ignore distances and scale.",
  ];
  return joined(words, " ");
}
