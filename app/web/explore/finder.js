/** Find pairs: by name, by look-alikes, and by histograms that filter. */

import { change, state } from "../shared/store.js";
import { each } from "../shared/text.js";
import { View } from "../shared/view.js";

const UP = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 };
const BINS = 20;
const HIGH = 34;
export const HISTOGRAMS = [
  {
    name: "confidence",
    title: "Confidence",
    help: "probability of the predicted class, both images, at the learned p",
  },
  { name: "cosine", title: "Photo–touch cosine", help: "cosine of the photo’s and the touch’s F̂, each seen alone" },
];

/** Counts in BINS equal bins over [low, high].
 * @param {number[] | Float64Array} all @param {number[]} span @param {(i: number) => boolean} wanted */
export function histogram(all, [low, high], wanted = () => true) {
  const counts = new Array(BINS).fill(0);
  all.forEach((v, i) => {
    if (wanted(i)) counts[Math.max(0, Math.min(BINS - 1, Math.floor(((v - low) / (high - low || 1)) * BINS)))] += 1;
  });
  return counts;
}

/** Move the lower or the upper end of a range by a number of bins.
 * @param {number[] | undefined} range @param {number[]} span @param {number} by @param {boolean} upper */
export function shifted(range, [low, high], by, upper) {
  const [from, to] = range ?? [low, high];
  const step = (by * (high - low)) / BINS;
  const inside = (v) => Math.max(low, Math.min(high, v));
  return upper ? [from, Math.max(from, inside(to + step))] : [Math.min(to, inside(from + step)), to];
}

export class Finder extends View {
  constructor(box, scene) {
    super(box);
    this.scene = scene;
    this.spans = Object.fromEntries(HISTOGRAMS.map(({ name }) => [name, [0, 1]]));
    this.search = box.querySelector("input[type=search]");
    this.search.value = state.find;
    this.search.oninput = () => change({ find: this.search.value.slice(0, 80) });
    this.alike = box.querySelector(".alike");
    this.alike.onchange = () => change({ alike: this.alike.querySelector("input").checked ? "1" : "" });
  }

  /** Show the filters that the data allow. */
  show() {
    const { unseen, pairs } = this.scene.facts;
    const count = pairs?.looks_like.filter(Boolean).length ?? 0;
    this.alike.hidden = !count;
    this.alike.querySelector("input").checked = state.alike === "1";
    this.alike.querySelector("small").textContent = `(${count})`;
    if (!unseen) return;
    this.spans = Object.fromEntries(HISTOGRAMS.map(({ name }) => [name, span(unseen.pairs[name])]));
    this.$(".histograms").innerHTML = each(HISTOGRAMS, ({ name, title, help }) => this.figure(name, title, help));
    for (const svg of this.box.querySelectorAll("svg")) this.listen(svg, svg.closest("figure").dataset.name);
    this.count();
  }

  figure(name, title, help) {
    const [low, high] = this.spans[name];
    return `<figure data-name="${name}" title="${help}"><figcaption>${title} <button type="button" class="link" hidden>clear</button></figcaption>
      <svg viewBox="0 0 ${BINS} ${HIGH}" preserveAspectRatio="none" role="slider" tabindex="0" aria-label="${title}: drag to keep a range; arrows move its lower end, Shift and arrows its upper end" aria-valuemin="${low}" aria-valuemax="${high}" aria-valuenow="${low}"><path class="all"/><path class="kept"/></svg>
      <span class="ends"><small>${low.toFixed(2)}</small><small>${high.toFixed(2)}</small></span></figure>`;
  }

  listen(svg, name) {
    let from = 0;
    const at = (event) => {
      const box = svg.getBoundingClientRect();
      const [low, high] = this.spans[name];
      return low + Math.max(0, Math.min(1, (event.clientX - box.left) / box.width)) * (high - low);
    };
    svg.onpointerdown = (event) => {
      svg.setPointerCapture(event.pointerId);
      from = at(event);
    };
    svg.onpointermove = (event) =>
      event.buttons &&
      this.set(
        name,
        [from, at(event)].sort((a, b) => a - b),
      );
    svg.onkeydown = (event) => {
      const by = UP[event.key];
      if (!by) return;
      event.preventDefault();
      this.set(name, shifted(this.scene.ranges[name], this.spans[name], by, event.shiftKey));
    };
    svg.parentElement.querySelector("button").onclick = () => this.set(name, null);
  }

  set(name, range) {
    const { ranges } = this.scene;
    const [low, high] = this.spans[name];
    range = range?.map((end) => +end.toFixed(4)); // as the address holds it: a link shows the same pairs
    if (range && range[1] > range[0] && (range[0] > low || range[1] < high)) ranges[name] = range;
    else delete ranges[name];
    const parts = Object.entries(ranges).map(([key, ends]) => [key, ...ends].join(":"));
    change({ range: parts.join("~") });
  }

  /** Draw the kept pairs and show their number. */
  count() {
    const { frames, ranges, facts, shown } = this.scene;
    const seen = (pair) => shown(pair) || shown(frames.pairs + pair);
    let kept = 0;
    for (let pair = 0; pair < frames.pairs; pair++) kept += seen(pair) ? 1 : 0;
    this.$(".found").textContent = kept === frames.pairs ? "" : `${kept} of ${frames.pairs} pairs shown`;
    for (const figure of this.box.querySelectorAll("figure")) {
      const { name } = figure.dataset;
      const own = facts.unseen.pairs[name];
      const all = histogram(own, this.spans[name]);
      const most = Math.max(1, ...all);
      const bars = (counts) =>
        each(counts, (n, i) =>
          n ? `M${i + 0.08} ${HIGH}V${HIGH - (n / most) * (HIGH - 2)}H${i + 0.92}V${HIGH}Z` : "",
        );
      figure.querySelector(".all").setAttribute("d", bars(all));
      figure.querySelector(".kept").setAttribute("d", bars(histogram(own, this.spans[name], seen)));
      const range = ranges[name];
      figure.querySelector("button").hidden = !range;
      const svg = figure.querySelector("svg");
      svg.setAttribute("aria-valuenow", (range ?? this.spans[name])[0].toFixed(2));
      svg.setAttribute("aria-valuetext", range ? `${range[0].toFixed(2)} to ${range[1].toFixed(2)}` : "all");
    }
  }
}

function span(all) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of all) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [Math.floor(20 * low) / 20, Math.ceil(20 * high) / 20];
}
