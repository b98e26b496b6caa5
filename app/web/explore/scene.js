/** The state of Explore: frames, stop, filters, selection, highlight. */

import { hidden, state } from "../shared/store.js";
import { HISTOGRAMS } from "./finder.js";
import { tagOf } from "./tags.js";

const HALF = { vis: "VIS", tac: "TAC" };
const isHistogram = (name) => HISTOGRAMS.some((one) => one.name === name);

export class Scene {
  set = "";
  /** @type {any} frames of the head itself, and those shown */
  own = null;
  /** @type {any} */
  frames = null;
  /** @type {any} */
  sprite = null;
  /** @type {{unseen: any, pairs: any, fit: any}} */
  facts = { unseen: null, pairs: null, fit: null };
  stop = 0;
  hovered = -1; // a point
  /** @type {number[]} points */
  near = [];
  /** @type {Set<number>} points */
  selected = new Set();
  /** @type {{kind: string, name: string} | null} the filter under the pointer */
  highlight = null;
  /** @type {{pairs: Set<number>, words: string} | null} a cell of the confusion matrix */
  only = null;
  halves = [true, true]; // whether photos and touches are shown
  mask = new Uint8Array(0); // points that all filters leave

  /** `data` as in load. */
  constructor(data) {
    this.load(data);
  }

  /** Show another set: its name, the frames of its head, its pictures, what is known of it. Another mode
   * shows other frames of the same pairs. */
  load({ set = "", own, sprite = null, facts = { unseen: null, pairs: null, fit: null } }) {
    this.set = set;
    this.own = own;
    this.frames = own;
    this.sprite = sprite;
    this.facts = facts;
    this.stop = 0;
    this.hovered = -1;
    this.near = [];
    this.selected = new Set();
    this.highlight = null;
    this.only = null;
    this.mask = new Uint8Array(2 * own.pairs).fill(1);
  }

  /** The kept ranges: histogram -> [from, to]. */
  get ranges() {
    const parts = state.range.split("~").map((one) => one.split(":"));
    const known = parts.filter(
      ([name, ...ends]) => isHistogram(name) && ends.length === 2 && ends.map(Number).every(Number.isFinite),
    );
    return Object.fromEntries(known.map(([name, from, to]) => [name, [+from, +to]]));
  }

  /** Take the stop of p. */
  follow() {
    this.stop = this.frames.stop(state.p);
  }

  /** Take the reading of the last chapter: one image alone has its own predictions, and its half of the points. */
  read() {
    const alone = state.chapter === "fooled" && state.reading !== "fused" && this.facts.unseen;
    this.frames.answered = alone ? alone.pairs.answers[state.reading] : null;
    const hides = hidden("modality");
    this.halves = ["VIS", "TAC"].map((name) => !hides.has(name) && !(alone && name !== HALF[state.reading]));
  }

  get p() {
    return this.frames.orders[this.stop];
  }

  shown = (point) => this.mask[point] === 1;

  /** True if a point is drawn in full colour. */
  lit = (point) => {
    if (this.highlight) {
      const { kind, name } = this.highlight;
      const pair = point % this.frames.pairs;
      if (kind === "modality") return (point < this.frames.pairs ? "VIS" : "TAC") === name;
      return kind === "domain"
        ? this.frames.domains[this.frames.domain[pair]] === name
        : this.frames.classes[this.frames.label[pair]] === name;
    }
    return !this.selected.size || this.selected.has(point);
  };

  /** Apply all filters; hidden points leave the selection. Returns true if any point left. */
  refilter() {
    const { frames, mask } = this;
    const wanted = this.wantedPairs();
    this.read();
    const seen = this.halves;
    for (let pair = 0; pair < frames.pairs; pair++) {
      const keep = wanted(pair);
      mask[pair] = keep && seen[0] ? 1 : 0;
      mask[frames.pairs + pair] = keep && seen[1] ? 1 : 0;
    }
    const before = this.selected.size;
    this.selected = new Set([...this.selected].filter(this.shown));
    if (this.hovered >= 0 && !this.shown(this.hovered)) this.hovered = -1;
    return before !== this.selected.size;
  }

  /** Whether a pair passes every filter, as a function of its number. */
  wantedPairs() {
    const { frames, facts, only } = this;
    const domains = frames.domains.map((name) => !hidden("domain").has(name));
    const classes = frames.classes.map((name) => !hidden("class").has(name));
    const alike = state.alike === "1" ? facts.pairs?.looks_like : null;
    const words = state.find.trim().toLowerCase();
    const text = (pair) =>
      `${facts.pairs?.name[pair] ?? ""} ${tagOf(frames, pair)} ${pair} ${frames.classes[frames.label[pair]]} ${frames.domains[frames.domain[pair]]}`.toLowerCase();
    const ranges = Object.entries(this.ranges).map(([name, [from, to]]) => [facts.unseen?.pairs[name], from, to]);
    return (pair) =>
      domains[frames.domain[pair]] &&
      classes[frames.label[pair]] &&
      alike?.[pair] !== "" &&
      (!only || only.pairs.has(pair)) &&
      ranges.every(([own, from, to]) => !own || (own[pair] >= from && own[pair] <= to)) &&
      (!words || words.split(/\s+/).every((word) => text(pair).includes(word)));
  }

  /** The only domain left by the filters; "" if there are several. */
  loneDomain() {
    const left = this.frames.domains.filter((name) => !hidden("domain").has(name));
    return left.length === 1 ? left[0] : "";
  }

  /** The active filters, in words; [] for none. */
  filtering() {
    const lists = [
      ["domain", this.frames.domains],
      ["class", this.frames.classes],
    ].flatMap(([kind, names]) => {
      const left = names.filter((name) => !hidden(kind).has(name));
      return left.length === names.length
        ? []
        : [
            left.length > 2
              ? `${left.length} ${kind === "class" ? "classes" : "domains"}`
              : left.join(", ") || `no ${kind}`,
          ];
    });
    if (state.alike === "1" && this.facts.pairs) lists.push("look-alikes");
    if (this.only) lists.push(this.only.words);
    if (state.find.trim()) lists.push(`“${state.find.trim()}”`);
    const ranges = HISTOGRAMS.filter(({ name }) => this.ranges[name]).map(
      ({ name, title }) => `${title.toLowerCase()} ${this.ranges[name].map((end) => end.toFixed(2)).join(" to ")}`,
    );
    return [...lists, ...ranges];
  }
}
