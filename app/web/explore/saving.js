/** The Save menu: the map as a picture, points as a table, a link to the view. */

import { orderText } from "../shared/frames.js";
import { axisNames } from "../shared/marks.js";
import { COLOURINGS } from "../shared/palette.js";
import { save } from "../shared/save.js";
import { stageNamed } from "../shared/stages.js";
import { state } from "../shared/store.js";
import { csv, png, svg } from "./exports.js";
import { METHODS } from "./maps.js";

const MODES = {
  moved: "weights fixed, p moved",
  retrained: "a head trained at this p",
  every: "one head for every p",
};

/** Copy a text; return an instruction if the browser forbids copying. */
async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
    return "Link copied.";
  } catch {
    return "Copy the address from the address bar.";
  }
}

export class Saving {
  constructor($, scene, maps) {
    this.$ = $;
    this.scene = scene;
    this.maps = maps;
    $(".menu").onclick = (event) => event.target.dataset.save && this.save(event.target.dataset.save);
  }

  /** Name the contents of the CSV in the menu. */
  label() {
    const { selected, filtering } = this.scene;
    const what = selected.size
      ? `The ${selected.size} selected points`
      : filtering.call(this.scene).length
        ? "The points shown"
        : "All points";
    this.$('.menu [data-save="csv"]').textContent = `${what} as CSV`;
  }

  caption() {
    const { frames, p } = this.scene;
    const { simulated, origin } = frames.meta.embeddings;
    const hides = this.scene.filtering();
    return [
      "OmniVaT",
      stageNamed(state.stage).name,
      `p = ${orderText(p)}`,
      MODES[frames.kind],
      frames.source && `trained on ${frames.source}`,
      METHODS[state.map],
      ...hides,
      simulated ? "simulated data" : origin,
      "● VIS ▲ TAC",
    ]
      .filter(Boolean)
      .join(" · ");
  }

  async save(kind) {
    const { frames, selected, shown, stop, p } = this.scene;
    const cloud = this.maps.now;
    const legend = COLOURINGS[state.colour].groups(frames);
    const name = `omnivat-${state.stage}-p${orderText(p)}`;
    if (kind === "csv") {
      const points = selected.size
        ? [...selected]
        : Array.from({ length: 2 * frames.pairs }, (_, i) => i).filter((i) => shown(i));
      save(
        `${name}${selected.size ? "-selected" : ""}.csv`,
        csv(frames, points, cloud.frame, stop, { stage: state.stage, kind: state.map }),
      );
    }
    if (kind === "png") save(`${name}.png`, await png(cloud, this.caption(), legend));
    if (kind === "svg") save(`${name}.svg`, svg(cloud, this.caption(), legend, axisNames(state.map)));
    if (kind === "link") this.$(".said").textContent = await copied(location.href);
    this.$(".save").open = false;
  }
}
