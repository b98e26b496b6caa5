/** Find pairs: by name, by look-alikes, and by histograms that filter. */

import { dragged, Scale } from "../shared/chart.js";
import { KEYS } from "../shared/order.js";
import { onClick } from "../shared/view.js";
import { shown } from "./maps.js";
import { $, change, draw, html, scene, state } from "./root.js";
import { HISTOGRAMS, rangesOf } from "./scene.js";

const BINS = 20;
const HIGH = 34;
const AREA = { wide: BINS, high: HIGH, pad: { left: 0, right: 0, top: 0, bottom: 0 } };

/** Return the numbers of values in BINS equal bins of a span; values outside it count in the outermost bins. `wanted`
 * selects by index.
 * @param {ArrayLike<number>} all @param {Span} span @param {Wanted} wanted */
export function histogram(all, [low, high], wanted = () => true) {
  const counts = new Array(BINS).fill(0);
  for (let i = 0; i < all.length; i++)
    if (wanted(i))
      counts[Math.max(0, Math.min(BINS - 1, Math.floor(((all[i] - low) / (high - low || 1)) * BINS)))] += 1;
  return counts;
}

/** Move the lower or the upper end of a range by a number of bins.
 * @param {Span | undefined} range @param {Span} span @param {number} by @param {boolean} upper @returns {Span} */
export function shifted(range, [low, high], by, upper) {
  const [from, to] = range ?? [low, high];
  const step = (by * (high - low)) / BINS;
  const inside = (/** @type {number} */ v) => Math.max(low, Math.min(high, v));
  return upper ? [from, Math.max(from, inside(to + step))] : [Math.min(to, inside(from + step)), to];
}

/** Return the range in the address once one histogram has another; one that keeps all is left out.
 * @param {string} kept @param {string} name @param {Span} span @param {Span | null} range */
export function ranged(kept, name, [low, high], range) {
  // as the address holds it: a link shows the same pairs
  const [from, to] = (range ?? [low, high]).map((end) => +end.toFixed(4));
  const ranges = rangesOf({ range: kept });
  if (to > from && (from > low || to < high)) ranges[name] = [from, to];
  else delete ranges[name];
  return Object.entries(ranges)
    .map(([key, ends]) => [key, ...ends].join(":"))
    .join("~");
}

/** Return the ends of a histogram. @param {ArrayLike<number>} all @returns {Span} */
function span(all) {
  const [low, high] = [Math.min, Math.max].map((end) => Array.from(all).reduce((a, b) => end(a, b)));
  return [Math.floor(20 * low) / 20, Math.ceil(20 * high) / 20];
}

/** Show what is searched for, the filters that the data allow, and how many pairs are kept. */
export function show() {
  const { frames, facts } = scene;
  const { unseen } = facts;
  const count = facts.pairs?.looks_like.filter(Boolean).length ?? 0;
  const search = $(".finder input[type=search]");
  if (search.value !== state.find) search.value = state.find;
  $(".finder .alike").hidden = !count;
  $(".alike input").checked = state.alike === "1";
  $(".alike small").textContent = `(${count})`;
  if (!unseen) return;
  const seen = (/** @type {number} */ pair) => shown(pair) || shown(frames.pairs + pair);
  const kept = Array.from(frames.label, (_, pair) => pair).filter(seen).length;
  $(".finder .found").textContent = kept === frames.pairs ? "" : `${kept} of ${frames.pairs} pairs shown`;
  draw($(".histograms"), html`${HISTOGRAMS.map((row) => histogramHtml(row, unseen.pairs[row.name], seen))}`);
}

/** Return a histogram with the range that is kept of it.
 * @param {typeof HISTOGRAMS[number]} row @param {ArrayLike<number>} all @param {Wanted} seen */
function histogramHtml({ name, title, help }, all, seen) {
  const ends = span(all);
  const range = rangesOf(state)[name];
  const [low, high] = ends.map((end) => end.toFixed(2));
  const [from, to] = (range ?? ends).map((end) => end.toFixed(2));
  const counts = histogram(all, ends);
  const most = Math.max(1, ...counts);
  const bars = (/** @type {number[]} */ counts) =>
    counts
      .map((n, i) => (n ? `M${i + 0.08} ${HIGH}V${HIGH - (n / most) * (HIGH - 2)}H${i + 0.92}V${HIGH}Z` : ""))
      .join("");
  return html`<figure data-name="${name}" title="${help}"><figcaption>${title} <button class="link"
    ${!range && "hidden"}>clear</button></figcaption>
    <svg class="chart" viewBox="0 0 ${BINS} ${HIGH}" preserveAspectRatio="none" role="slider" tabindex="0"
      aria-label="${title}: drag to keep a range; arrows move its lower end, Shift and arrows its upper end"
      aria-valuemin="${low}" aria-valuemax="${high}" aria-valuenow="${from}"
      aria-valuetext="${range ? `${from} to ${to}` : "all"}"><path class="all" d="${bars(counts)}"/><path class="kept"
      d="${bars(histogram(all, ends, seen))}"/></svg>
    <span class="ends"><small>${low}</small><small>${high}</small></span></figure>`;
}

/** Let a range be dragged, moved by keys, and cleared. */
export function listen() {
  const box = $(".histograms");
  /** Its name and span, and a function that keeps a range of it. @param {Found} part */
  const of = (part) => {
    const { name } = part.closest("figure").dataset;
    const ends = span(/** @type {Unseen} */ (scene.facts.unseen).pairs[/** @type {"cosine"} */ (name)]);
    const keep = (/** @type {Span | null} */ range) => change({ range: ranged(state.range, name, ends, range) });
    return { name, ends, keep };
  };
  let from = 0;
  dragged(box, (event, svg) => {
    const { ends, keep } = of(svg);
    const to = new Scale({ ...AREA, xs: ends }).under(event, svg);
    if (event.type === "pointerdown") from = to;
    else keep([Math.min(from, to), Math.max(from, to)]);
  });
  box.onkeydown = (/** @type {Found} */ event) => {
    const by = KEYS[event.key];
    if (!by) return;
    event.preventDefault();
    const { name, ends, keep } = of(event.target);
    keep(shifted(rangesOf(state)[name], ends, by, event.shiftKey));
  };
  onClick(box, { button: (button) => of(button).keep(null) });
}
