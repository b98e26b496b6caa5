/** The map of a run: F̂ of the set's pairs at one epoch. */

import { Cloud } from "../shared/cloud.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames } from "../shared/marks.js";
import { colouring, colouringsOf, onTheme } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { bytesOf, each, escaped, options } from "../shared/text.js";

export class RunMap {
  constructor(panel) {
    this.panel = panel;
    this.cloud = null;
    this.choice = panel.querySelector(".colouring");
    this.choice.onchange = () => this.paint();
    onTheme(() => this.paint());
  }

  /** A new run: the pairs on its maps, and the colours that tell them apart. */
  begin(started) {
    const { reach, domain } = started;
    const box = this.panel.querySelector(".map");
    this.frames = { pairs: domain.length, kind: "features", ...started };
    /** @type {[Point, Point]} */
    this.bounds = [
      [-reach, -reach],
      [reach, reach],
    ];
    this.choice.innerHTML = options(colouringsOf(this.frames).map(([key, { label }]) => [key, label.toLowerCase()]));
    box.innerHTML = "";
    this.cloud = new Cloud(box, 2 * domain.length);
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
    const all = () => true;
    this.cloud.layers = layersOf(this.frames, 0, all, all, 0.13, this.choice.value);
    this.cloud.show({ points: this.points, bounds: /** @type {[Point, Point]} */ (this.bounds) });
    const key = ([name, colour]) =>
      `<span class="key"><i style="background:${colour}"></i>${escaped(name)}${name === this.frames.source ? " <b>source</b>" : ""}</span>`;
    this.panel.querySelector(".legend").innerHTML = each(
      colouring(this.frames, this.choice.value).groups(this.frames),
      key,
    );
  }
}
