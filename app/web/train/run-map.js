/** The map of a run: F̂ of the set's pairs at one epoch. */

import { Cloud } from "../shared/cloud.js";
import { keys } from "../shared/filters.js";
import { layersOf } from "../shared/layers.js";
import { axes, axisNames } from "../shared/marks.js";
import { colouring, colouringsOf, onTheme } from "../shared/palette.js";
import { listen } from "../shared/pointer.js";
import { bytesOf, options, put } from "../shared/text.js";
import { View } from "../shared/view.js";

export class RunMap extends View {
  /** @type {Cloud | null} */
  cloud = null;
  /** @type {Started | null} */
  started = null;
  points = new Uint16Array(0);

  /** @param {Found} box */
  constructor(box) {
    super(box);
    this.choice = this.$(".colouring");
    this.choice.onchange = () => this.paint();
    onTheme(() => this.paint());
  }

  /** The pairs of a run, with what colours them. @param {Started} started @returns {Colourable} */
  frames = ({ domains, classes, domain, label, source }) => ({
    ...{ domains, classes, domain, label, source, pairs: domain.length, labelled: true },
    ...{ kind: "features", headless: true, prediction: [], confidence: [], answered: null, columns: {} },
  });

  /** Show the newest map of a run; a new run brings its pairs, and the colours that tell them apart.
   * @param {Started} started @param {string | null} coded base64 of u16 pairs */
  show(started, coded) {
    if (!coded) return;
    if (this.started !== started) this.begin(started);
    this.points = new Uint16Array(bytesOf(coded).buffer);
    this.paint();
  }

  /** @param {Started} started */
  begin(started) {
    this.started = started;
    const offered = colouringsOf(this.frames(started));
    put(this.choice, options(offered.map(({ id, title }) => [id, title.toLowerCase()])));
    const map = this.$(".map");
    map.replaceChildren();
    this.cloud = new Cloud(map, 2 * started.domain.length);
    this.cloud.painters = [axes(() => axisNames("pca"))];
    listen(this.cloud, {});
  }

  paint() {
    if (!this.cloud || !this.started) return;
    const frames = this.frames(this.started);
    const { reach } = this.started;
    const all = () => true;
    this.cloud.layers = layersOf(frames, 0, all, all, 0.13, this.choice.value);
    this.cloud.show({
      points: this.points,
      bounds: [
        [-reach, -reach],
        [reach, reach],
      ],
    });
    put(this.$(".legend"), keys(colouring(frames, this.choice.value).groups(frames), frames.source));
  }
}
