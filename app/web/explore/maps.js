/** The map of the open step. */

import { Cloud } from "../shared/cloud.js";
import { orderText } from "../shared/frames.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames, lassoLine, neighbourRings, pairLine, shapes } from "../shared/marks.js";
import { means, names } from "../shared/means.js";
import { asText, values } from "../shared/measures.js";
import { colouring, colouringsOf, isDark, onTheme } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { radios } from "../shared/radios.js";
import { isStill, stageNamed } from "../shared/stages.js";
import { change, state } from "../shared/store.js";
import { modeOf } from "../shared/tables.js";
import { escaped, options } from "../shared/text.js";
import { Beside } from "./beside.js";
import { pictures } from "./pictures.js";

export const METHODS = { pca: "PCA", umap: "UMAP" };
const TOOLS = 46; // CSS pixels that the tools of the workbench cover at the top of the map

export class Maps {
  /** `on` as in pointer.js. */
  constructor($, scene, on) {
    this.$ = $;
    this.scene = scene;
    const count = 2 * scene.own.pairs;
    this.now = new Cloud($(".map"), count);
    const drawing = listen(this.now, on);
    const frames = () => scene.frames;
    const marks = [
      pictures(scene),
      means(frames, scene.shown),
      (x, cloud) => neighbourRings(x, cloud, scene.near),
      (x, cloud) => state.pin !== null && pairLine(x, cloud, state.pin, "#dc2626"),
      (x, cloud) => {
        const pair = scene.hovered % scene.frames.pairs;
        if (scene.hovered >= 0 && pair !== state.pin) pairLine(x, cloud, pair, isDark() ? "#38bdf8" : "#1e293b");
      },
    ];
    const named = names(frames, scene.shown);
    const scaled = axes(() => axisNames(this.kind()));
    this.now.painters = [
      (x, cloud) => (state.chapter === "analyse" ? scaled(x, cloud) : shapes(x, cloud, meaning(frames()))),
      ...marks,
      (x, cloud) => cloud.view.zoom < 3 && named(x, cloud),
      (x) => lassoLine(x, drawing.polygon),
    ];
    this.beside = new Beside($, scene, this, on);
    onTheme(() => {
      this.now.redraw();
      this.beside.cloud?.redraw();
    });
  }

  paintMarks = () => {
    this.now.paintMarks();
    this.beside.paintMarks();
  };

  /** Another set or chapter: room for its points, the whole map in view. */
  reset() {
    const over = getComputedStyle(this.$(".tools")).position === "absolute"; // on a phone they stand above the map
    this.now.top = state.chapter === "analyse" && over && !this.beside.open ? TOOLS : 0;
    if (this.now.count !== 2 * this.scene.own.pairs) this.now.hold(2 * this.scene.own.pairs);
    this.now.resetView();
    this.beside.follow();
  }

  /** The method of the map: the chosen one if this step has it. */
  kind(stage = state.stage) {
    const kinds = this.scene.frames.kinds(stage);
    return kinds.includes(state.map) ? state.map : kinds[0];
  }

  /** The choice between the kinds of map that the open step has. */
  showKinds() {
    const kinds = this.scene.frames.kinds(state.stage);
    const options = kinds.map((key) => ({ key, label: METHODS[key] ?? key }));
    radios(
      this.$(".kinds"),
      options,
      () => this.kind(),
      (map) => change({ map }),
    );
  }

  /** The colourings that the frames have. */
  showColourings() {
    const { frames } = this.scene;
    this.$(".colouring").innerHTML = options(colouringsOf(frames).map(([key, c]) => [key, c.label]));
    const known = colouringsOf(frames).find(([, c]) => c === colouring(frames, state.colour));
    this.$(".colouring").value = known?.[0];
  }

  showLayers() {
    const { frames, stop, shown, lit } = this.scene;
    this.now.halves = this.scene.halves;
    this.now.layers = layersOf(frames, stop, shown, lit);
    this.now.redraw();
    this.beside.show();
  }

  /** Draw the open step at the present stop. */
  showNow() {
    const { frames, stop } = this.scene;
    const kind = this.kind();
    if (!kind) return;
    const frame = frames.positions(kind, state.stage, stop);
    this.now.show(frame);
    this.beside.show();
    this.now.box.dataset.order = frames.orders[isStill(state.stage, frames) ? stop : frame.drawn];
    this.$(".approximate").textContent = notes(frames, frame, stop, kind);
    const stage = stageNamed(state.stage);
    this.$('[data-panel="step"] .map-title').innerHTML = this.title(
      `${stage.name}, p = ${orderText(frames.orders[stop])}`,
      state.stage,
      kind,
    );
  }

  /** The title of a map: its step, its method, and the gaps of the points shown. */
  title(name, stage, kind) {
    const { frames, stop } = this.scene;
    const domain = this.scene.loneDomain();
    const hides = this.scene.filtering();
    const gap = (measure, words, only) => {
      const value = values(frames, measure, stage, only)?.[stop];
      return Number.isFinite(value) ? `<span class="gap">${words} <b>${asText(measure, value, 2)}</b></span>` : "";
    };
    const gaps = domain
      ? gap("modality_gap", `modality gap in ${escaped(domain)}`, domain)
      : gap("modality_gap", "modality gap", "") + gap("domain_gap", "domain gap", "");
    const of =
      hides.length && !(domain && hides.length === 1)
        ? `<span>${hides.map(escaped).join(" · ")}: gaps are of ${domain ? "the whole domain" : "all pairs"}</span>`
        : "";
    return `<span class="where-at">${name} <small>${METHODS[kind] ?? kind}</small></span>${gaps}${of}`;
  }
}

const meaning = ({ signals }) => (signals ? "● one recording  ▲ the other" : "● photo  ▲ touch");

/** What to know about the map: how far its neighbours can be trusted, and which stop it shows. */
export function notes(frames, frame, stop, kind) {
  const parts = [];
  if (Number.isFinite(frame.trust) && state.chapter === "analyse") parts.push(`Trust ${frame.trust.toFixed(2)}.`);
  if (kind !== state.map) parts.push(`This step has no ${METHODS[state.map]}.`);
  if (frame.stops > 1 && frame.drawn !== stop)
    parts.push(`Shown is p = ${orderText(frames.orders[frame.drawn])}, the nearest of ${frame.stops} stops.`);
  if (state.chapter === "analyse") {
    if (isStill(state.stage, frames) && frame.stops === 1 && state.stage !== "raw")
      parts.push("One map for every p: the transform changes no distance.");
    const { note } = modeOf(frames);
    if (note && !isStill(state.stage, frames)) parts.push(note);
    if (kind === "umap") parts.push("Distances and scale have no meaning.");
  }
  return parts.join(" ");
}
