/** Actions in Explore: point, pick, step, select, find neighbours. */

import { featuresOf } from "../shared/stages.js";
import { change, state } from "../shared/store.js";
import { findNeighbours } from "./neighbours.js";

export class Acts {
  constructor(page) {
    this.page = page;
    this.scene = page.scene;
  }

  /** Pointer and key callbacks of a map, as in pointer.js. */
  pointing() {
    return {
      wanted: (point) => this.scene.shown(point),
      hover: (point) => this.hover(point, true),
      pick: (point) => this.pick(point),
      lasso: (points) => this.select(points),
      next: (by) => this.next(by),
      lassoMode: () => this.page.lassoMode,
      current: () => this.scene.hovered,
    };
  }

  hover(point, pointed = false) {
    const { scene } = this;
    if (point === scene.hovered) return;
    scene.hovered = point;
    this.page.maps.now.marks.style.cursor =
      point >= 0 ? "pointer" : this.page.lassoMode ? "crosshair" : "grab";
    this.page.maps.paintMarks();
    this.page.showCard();
    this.page.peek(point < 0 ? -1 : point % scene.frames.pairs, pointed);
  }

  pick(point) {
    this.scene.near = [];
    if (point < 0) return change({ pin: null });
    const pair = point % this.scene.frames.pairs;
    return change({ pin: pair, vis: `row:${pair}`, tac: `row:${pair}` });
  }

  next(by) {
    const { scene } = this;
    const total = 2 * scene.frames.pairs;
    for (let i = 1; i <= total; i++) {
      const point = (Math.max(scene.hovered, -1) + by * i + total * 2) % total;
      if (scene.shown(point)) return this.hover(point);
    }
    return undefined;
  }

  select(points) {
    this.scene.selected = new Set(points);
    this.page.maps.showLayers();
    this.page.showSelected();
  }

  /** Show and list the pairs of one cell of the confusion matrix; null shows all again. */
  onlyCell(cell) {
    const { scene } = this;
    const { classes } = scene.facts.unseen;
    const words = cell && `${classes[cell.truth]} predicted as ${classes[cell.answer]}`;
    scene.only = cell && { pairs: new Set(cell.pairs), words };
    this.page.refilter();
    this.select(
      cell ? cell.pairs.flatMap((pair) => [pair, pair + scene.frames.pairs]).filter(scene.shown) : [],
    );
  }

  async near(modality) {
    const { scene } = this;
    const point = state.pin + scene.frames.pairs * modality;
    const asked = {
      frames: scene.frames,
      sprite: scene.sprite,
      point,
      stage: featuresOf(state.stage),
      p: scene.p,
      onPick: (one) => this.pick(one),
    };
    scene.near = await findNeighbours(this.page.$(".card .found"), asked);
    this.page.maps.paintMarks();
  }
}
