/** The map that the visitor starts from: raw embeddings, beside the stage that is looked at. */

import { Cloud } from "./cloud.js";
import { values } from "./curves.js";
import { axes, axisNames } from "./marks.js";
import { listen } from "./pointer.js";

/** `on` as in pointer.js; `painters` draw the same marks as on the other map. */
export function beforeMap(box, frames, on, painters) {
  const cloud = new Cloud(box, 2 * frames.pairs);
  listen(cloud, on);
  cloud.painters = [axes(() => axisNames("pca")), ...painters];
  return cloud;
}

/** What stands above each map: both gaps there, how far they have closed, and what it is worth. */
export function title(frames, stage, stop, name) {
  const at = (gap, of) => values(frames, gap, of)?.[stop];
  const parts = ["modality_gap", "domain_gap"].map((gap) => {
    const own = at(gap, stage);
    const raw = at(gap, "raw");
    if (!Number.isFinite(own)) return "";
    const by = Math.round(100 * (1 - own / raw));
    const change = stage === "raw" || !Number.isFinite(by) ? ""
      : `<small class="${by > 0 ? "right" : "wrong"}">${by > 0 ? "−" : "+"}${Math.abs(by)} %</small>`;
    return `<span class="gap">${gap === "modality_gap" ? "modality gap" : "domain gap"} <b>${own.toFixed(2)}</b>${change}</span>`;
  });
  const right = stage === "raw" ? NaN : values(frames, "accuracy", stage)?.[stop];
  if (Number.isFinite(right)) parts.push(`<span class="gap">accuracy <b>${Math.round(100 * right)} %</b></span>`);
  return `<span class="where-at">${name}</span>${parts.join("")}`;
}
