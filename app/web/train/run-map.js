/** The map of a run: F̂ of the set's pairs at one epoch. */

import { Cloud } from "../shared/cloud.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames } from "../shared/marks.js";
import { COLOURINGS, onTheme } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { bytesOf, escaped } from "../shared/text.js";

export class RunMap {
  constructor(box, legend) {
    this.box = box;
    this.legend = legend;
    this.cloud = null;
    this.colour = "domain";
    onTheme(() => this.paint());
  }

  /** A new run: the pairs on its maps. */
  begin(started) {
    const pairs = started.domain.length;
    this.frames = { pairs, ...started };
    this.bounds = [
      [-started.reach, -started.reach],
      [started.reach, started.reach],
    ];
    this.box.innerHTML = "";
    this.cloud = new Cloud(this.box, 2 * pairs);
    this.cloud.painters = [axes(() => axisNames("pca"))];
    listen(this.cloud, {});
  }

  /** coded: base64 of u16 pairs. */
  show(coded) {
    if (!this.cloud || !coded) return;
    this.points = new Uint16Array(bytesOf(coded).buffer);
    this.paint();
  }

  paint() {
    if (!this.cloud || !this.points) return;
    this.cloud.layers = layersOf(
      this.frames,
      0,
      () => true,
      () => true,
      0.13,
      this.colour,
    );
    this.cloud.show({ points: this.points, bounds: this.bounds });
    this.legend.innerHTML = COLOURINGS[this.colour]
      .groups(this.frames)
      .map(
        ([name, colour]) =>
          `<span class="key"><i style="background:${colour}"></i>${escaped(name)}${name === this.frames.source ? " <b>source</b>" : ""}</span>`,
      )
      .join("");
  }
}
