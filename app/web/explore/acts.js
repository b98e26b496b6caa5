/** Actions in Explore: point, pick, step, select, find neighbours. */

import { featuresOf } from "../shared/stages.js";
import { change, state } from "../shared/store.js";
import { findNeighbours, showNeighbours } from "./neighbours.js";
import { packed, unpacked } from "./selected.js";

export class Acts {
  constructor(page) {
    this.page = page;
    this.scene = page.scene;
    this.nearest = null; // {key, found}: neighbours of the pinned pair
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
    this.page.maps.now.marks.style.cursor = point >= 0 ? "pointer" : this.page.lassoMode ? "crosshair" : "grab";
    this.page.maps.paintMarks();
    this.page.showCard();
    this.page.peek(point < 0 ? -1 : point % scene.frames.pairs, pointed);
  }

  /** Pin the pair of a point, for the other tabs too if it is of their set, and find its neighbours. */
  pick(point) {
    const { scene } = this;
    scene.near = [];
    if (point < 0) return change({ pin: null });
    const pair = point % scene.frames.pairs;
    const ref = scene.set ? {} : { vis: `row:${pair}`, tac: `row:${pair}` };
    change({ pin: pair, ...ref });
    return this.near(point < scene.frames.pairs ? 0 : 1);
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
    this.nameSelected();
    this.page.maps.showLayers();
    this.page.showPictures();
    if (points.length) this.page.panels.show("grid");
  }

  /** Keep the selection in the address, or take it from there. */
  nameSelected() {
    change({ sel: packed(this.scene.selected) });
  }

  selectNamed() {
    const points = unpacked(state.sel, 2 * this.scene.frames.pairs).filter(this.scene.shown);
    if (points.length) this.select(points);
  }

  /** Show and list the pairs of one cell of the confusion matrix; null shows all again. */
  onlyCell(cell) {
    const { scene } = this;
    const { classes } = scene.facts.unseen;
    const words = cell && `${classes[cell.truth]} predicted as ${classes[cell.answer]}`;
    scene.only = cell && { pairs: new Set(cell.pairs), words };
    this.page.refilter();
    this.select(cell ? cell.pairs.flatMap((pair) => [pair, pair + scene.frames.pairs]).filter(scene.shown) : []);
  }

  /** The stage whose neighbours are known: heads trained at each p are not kept. */
  get nearStage() {
    return this.scene.frames.kind === "retrained" ? "raw" : featuresOf(state.stage);
  }

  key = () => `${this.scene.set} ${state.pin} ${this.nearStage} ${this.scene.p}`;

  async near(modality) {
    const { scene } = this;
    const point = state.pin + scene.frames.pairs * modality;
    const key = this.key();
    const box = this.page.$(".card .found");
    const found = await findNeighbours(box, { set: scene.set, point, stage: this.nearStage, p: scene.p });
    if (key !== this.key()) return;
    this.nearest = { key, found };
    this.showNear();
    this.page.maps.paintMarks();
  }

  /** Show the neighbours of the pinned pair if they are of this step and p. */
  showNear() {
    const { scene, nearest } = this;
    const box = this.page.$(".card .found");
    const known = nearest?.key === this.key() ? nearest.found : [];
    scene.near = known.map(({ point }) => point);
    if (box && known.length) showNeighbours(box, known, scene, (point) => this.pick(point));
  }
}
