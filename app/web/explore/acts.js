/** Actions in Explore: point, pick, step, select, find neighbours. */

import { ask, inSet, refused } from "../shared/api.js";
import { thumbnail } from "../shared/card.js";
import { featuresOf } from "../shared/stages.js";
import { change, state } from "../shared/store.js";
import { has } from "../shared/tables.js";
import { each, escaped } from "../shared/text.js";
import { onClick } from "../shared/view.js";

export class Acts {
  constructor(board) {
    this.board = board;
    this.scene = board.scene;
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
      lassoMode: () => this.board.lassoMode,
      current: () => this.scene.hovered,
    };
  }

  hover(point, pointed = false) {
    const { scene } = this;
    if (point === scene.hovered) return;
    scene.hovered = point;
    this.board.maps.now.marks.style.cursor = point >= 0 ? "pointer" : this.board.lassoMode ? "crosshair" : "grab";
    this.board.maps.paintMarks();
    this.board.showCard();
    this.board.peek(point < 0 ? -1 : point % scene.frames.pairs, pointed);
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
    this.board.maps.showLayers();
    this.board.showPictures();
    if (points.length) this.board.panels.show("grid");
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
    this.board.refilter();
    this.select(cell ? cell.pairs.flatMap((pair) => [pair, pair + scene.frames.pairs]).filter(scene.shown) : []);
  }

  /** The stage whose neighbours are known: heads trained at each p are not kept. */
  get nearStage() {
    return has(this.scene.frames, "heads") ? "raw" : featuresOf(state.stage);
  }

  key = () => `${this.scene.set} ${state.pin} ${this.nearStage} ${this.scene.p}`;

  async near(modality) {
    const { scene } = this;
    const point = Number(state.pin) + scene.frames.pairs * modality;
    const key = this.key();
    const box = this.board.$(".card .found");
    const found = await findNeighbours(box, { set: scene.set, point, stage: this.nearStage, p: scene.p });
    if (key !== this.key()) return;
    this.nearest = { key, found };
    this.showNear();
    this.board.maps.paintMarks();
  }

  /** Show the neighbours of the pinned pair if they are of this step and p. */
  showNear() {
    const { scene, nearest } = this;
    const box = this.board.$(".card .found");
    const known = nearest?.key === this.key() ? nearest.found : [];
    scene.near = known.map(({ point }) => point);
    if (box && known.length) showNeighbours(box, known, scene, (point) => this.pick(point));
  }
}

/** Request the neighbours of a point; `box` shows the progress, or why there are none. */
async function findNeighbours(box, { set, point, stage, p }) {
  if (box) box.textContent = "Computing this stage for the whole set…";
  try {
    return (await ask(inSet("neighbours", set), { point, stage, order: p })).neighbours;
  } catch (error) {
    refused(error, (sentence) => box && (box.textContent = sentence));
    return [];
  }
}

/** Show neighbours as pictures; a click picks one. */
export function showNeighbours(box, found, { frames, sprite }, onPick) {
  box.innerHTML = each(found, ({ point, cosine }) => {
    const tac = point >= frames.pairs;
    const own = point % frames.pairs;
    const of = escaped(`${frames.classes[frames.label[own]]}, ${frames.domains[frames.domain[own]]}`);
    const name = `${tac ? "TAC" : "VIS"} of pair ${own}, ${of}, cosine ${cosine.toFixed(3)}`;
    return `<button type="button" data-point="${point}" title="${name}" aria-label="${name}">${thumbnail(sprite, point, 48, tac ? "TAC" : "VIS")}<small>${tac ? "TAC" : "VIS"} ${cosine.toFixed(2)}</small></button>`;
  });
  onClick(box, { "[data-point]": ({ dataset }) => onPick(+dataset.point) });
}

const MOST = 4000; // letters; a longer selection is left out of the address

/** @param {Iterable<number>} points */
export function packed(points) {
  const runs = [];
  for (const point of [...points].sort((a, b) => a - b)) {
    const last = runs.at(-1);
    if (last && last[1] === point - 1) last[1] = point;
    else runs.push([point, point]);
  }
  let before = 0;
  const text = runs.map(([from, to]) => {
    const gap = (from - before).toString(36);
    before = to;
    return to > from ? `${gap}.${(to - from).toString(36)}` : gap;
  });
  return text.join("-").length > MOST ? "" : text.join("-");
}

/** The points of a packed text below `count`; what is not such a text has none.
 * @param {string} text @param {number} count */
export function unpacked(text, count) {
  const points = [];
  let at = 0;
  for (const run of text ? text.split("-") : []) {
    const [gap, more = 0] = run.split(".").map((part) => Number.parseInt(part, 36));
    if (!(gap >= 0 && more >= 0) || at + gap + more >= count) return points;
    at += gap;
    for (let i = 0; i <= more; i++) points.push(at + i);
    at += more;
  }
  return points;
}
