/** The two maps: the raw embedding and the open step. */

import { Cloud } from "../shared/cloud.js";
import { orderText } from "../shared/frames.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames, lassoLine, neighbourRings, pairLine } from "../shared/marks.js";
import { means } from "../shared/means.js";
import { asText, values } from "../shared/measures.js";
import { isDark, onTheme } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { isStill, stageNamed } from "../shared/stages.js";
import { state } from "../shared/store.js";
import { escaped } from "../shared/text.js";
import { pictures } from "./pictures.js";

export const METHODS = { pca: "PCA", umap: "UMAP" };

export class Maps {
  /** `on` as in pointer.js. */
  constructor($, scene, on) {
    this.$ = $;
    this.scene = scene;
    const count = 2 * scene.own.pairs;
    this.now = new Cloud($(".map"), count);
    this.before = new Cloud($(".still"), count);
    const drawing = listen(this.now, on);
    listen(this.before, { ...on, lassoMode: () => false });
    const marks = [
      pictures(scene),
      means(() => scene.frames, scene.shown),
      (x, cloud) => neighbourRings(x, cloud, scene.near),
      (x, cloud) => state.pin !== null && pairLine(x, cloud, state.pin, "#dc2626"),
      (x, cloud) => {
        const pair = scene.hovered % scene.frames.pairs;
        if (scene.hovered >= 0 && pair !== state.pin)
          pairLine(x, cloud, pair, isDark() ? "#38bdf8" : "#1e293b");
      },
    ];
    this.before.painters = [axes(() => axisNames(this.beforeKind())), ...marks];
    this.now.painters = [axes(() => axisNames(state.map)), ...marks, (x) => lassoLine(x, drawing.polygon)];
    onTheme(() => this.redraw());
  }

  each(action) {
    action(this.now);
    action(this.before);
  }

  redraw() {
    this.each((cloud) => cloud.redraw());
  }

  paintMarks() {
    this.each((cloud) => cloud.paintMarks());
  }

  /** The raw map uses the method of the other map if the frames have it. */
  beforeKind() {
    const kinds = this.scene.frames.kinds("raw");
    return kinds.includes(state.map) ? state.map : kinds[0];
  }

  showLayers() {
    const { frames, stop, shown, lit } = this.scene;
    this.now.layers = this.before.layers = layersOf(frames, stop, shown, lit);
    this.redraw();
  }

  /** Draw the open step at the present stop. */
  showNow() {
    const { frames, stop } = this.scene;
    const frame = frames.positions(state.map, state.stage, stop);
    this.now.show(frame);
    this.now.box.dataset.order = frames.orders[isStill(state.stage, frames) ? stop : frame.drawn];
    this.$(".approximate").textContent = notes(frames, frame, stop);
    const stage = stageNamed(state.stage);
    this.$(".now .map-title").innerHTML = this.title(
      `${stage.name}, p = ${orderText(frames.orders[stop])}`,
      state.stage,
      state.map,
    );
  }

  /** Draw the raw embedding; it is the only map if it is the open step. */
  showBefore() {
    const { frames } = this.scene;
    const kind = this.beforeKind();
    this.$(".maps").classList.toggle("alone", state.stage === "raw" || !kind);
    if (!kind) return;
    this.before.show(frames.positions(kind, "raw", 0));
    this.$(".before .map-title").innerHTML = this.title(
      'Raw<span class="long"> embedding</span>',
      "raw",
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
      return Number.isFinite(value)
        ? `<span class="gap">${words} <b>${asText(measure, value, 2)}</b></span>`
        : "";
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

/** A note on the map; most maps need none. */
export function notes(frames, frame, stop) {
  const parts = [];
  if (isStill(state.stage, frames) && frame.stops === 1 && state.stage !== "raw")
    parts.push("One map for every p: the transform changes no distance.");
  else if (frame.stops > 1 && frame.drawn !== stop)
    parts.push(`This map has ${frame.stops} stops; shown is p = ${orderText(frames.orders[frame.drawn])}.`);
  if (frames.kind === "retrained" && !["raw"].includes(state.stage))
    parts.push("Each stop is a different head, so points jump.");
  if (frames.kind === "moved" && !isStill(state.stage, frames))
    parts.push("Weights stay fixed while p moves.");
  if (state.map === "umap")
    parts.push("UMAP keeps neighbours together. Its distances, axes and scale have no meaning.");
  return parts.join(" ");
}
