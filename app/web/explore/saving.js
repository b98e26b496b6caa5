/** The Save menu: the map as a picture, points as a table, a link to the view. */

import { attempt, inSet, made, refused } from "../shared/api.js";
import { orderText } from "../shared/frames.js";
import { axisNames } from "../shared/marks.js";
import { colouring } from "../shared/palette.js";
import { save } from "../shared/save.js";
import { stageNamed } from "../shared/stages.js";
import { state } from "../shared/store.js";
import { modeOf } from "../shared/tables.js";
import { csv, png, svg } from "./exports.js";
import { METHODS } from "./maps.js";
import { loadTags, tagsCsv } from "./tags.js";

/** Copy the address together with the map's picture, if there is a map; return what was done, in words. */
export async function share(saving) {
  const text = location.href;
  try {
    const picture = saving.picture();
    const link = new Blob([text], { type: "text/plain" });
    await navigator.clipboard.write([new ClipboardItem({ "text/plain": link, "image/png": picture })]);
    return "Copied";
  } catch {
    try {
      await navigator.clipboard.writeText(text);
      return "Link copied";
    } catch {
      return "Copy the address";
    }
  }
}

/** Show the link to this view; a click beside it closes it. */
export function showLink(box) {
  const link = location.href;
  box.innerHTML = '<h3>This view</h3><input type="text" readonly aria-label="Link to this view">';
  const field = box.querySelector("input");
  field.value = link;
  field.onfocus = () => field.select();
  box.showPopover?.();
}

export class Saving {
  constructor($, scene, maps, onTags) {
    this.onTags = onTags;
    this.$ = $;
    this.scene = scene;
    this.maps = maps;
    $(".load-tags input").onchange = (event) => this.load(event.target);
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
      !frames.headless && `p = ${orderText(p)}`,
      modeOf(frames).caption,
      frames.source && `trained on ${frames.source}`,
      METHODS[state.map],
      ...hides,
      simulated ? "simulated data" : origin,
      "● VIS ▲ TAC",
    ]
      .filter(Boolean)
      .join(" · ");
  }

  /** Save the open map, the curves and the staircase as one page that the server makes. */
  async figure(name) {
    const { kind: mode } = this.scene.frames;
    const { stage, colour } = state;
    const map = this.maps.kind();
    const question = { stage, map, colour, mode, order: this.scene.p };
    save(`${name}.html`, await made(inSet("save/figure", this.scene.set), question));
  }

  /** The map as a PNG. */
  picture() {
    const { frames } = this.scene;
    return png(this.maps.now, this.caption(), colouring(frames, state.colour).groups(frames));
  }

  /** Load the tags of a CSV and say how many there are. */
  async load(input) {
    const say = (sentence) => {
      this.$(".announcement").textContent = this.$(".load-tags").title = sentence;
      this.$(".save").open = false;
    };
    await attempt(async () => {
      say(`${loadTags(this.scene.own, await input.files[0].text())} pairs have a tag now.`);
      this.onTags();
    }, say);
    input.value = "";
  }

  async save(kind) {
    const { frames, selected, shown, stop, p } = this.scene;
    const cloud = this.maps.now;
    const legend = colouring(frames, state.colour).groups(frames);
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
    if (kind === "png") save(`${name}.png`, await this.picture());
    if (kind === "tags") save("omnivat-tags.csv", tagsCsv(frames, this.scene.facts.pairs?.name));
    if (kind === "svg") save(`${name}.svg`, svg(cloud, this.caption(), legend, axisNames(state.map)));
    if (kind === "figure")
      await this.figure(name).catch((error) =>
        refused(error, (words) => (this.$(".announcement").textContent = words)),
      );
    this.$(".save").open = false;
  }
}
