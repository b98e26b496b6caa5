/** Find pairs: by name, by look-alikes, and by histograms that filter. */

import { shown } from "./maps.js";
import { $, all, change, html, put, scene, state } from "./root.js";
import { HISTOGRAMS, rangesOf } from "./scene.js";

/** @type {Record<string, number>} */
const UP = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 };
const BINS = 20;
const HIGH = 34;

/** Counts in BINS equal bins over a span. @param {ArrayLike<number>} all @param {Span} span @param {Wanted} wanted */
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

/** The range in the address once one histogram has another; one that keeps all is left out.
 * @param {string} kept @param {string} name @param {Span} span @param {Span | null} range */
export function ranged(kept, name, [low, high], range) {
  const [from, to] = (range ?? [low, high]).map((end) => +end.toFixed(4)); // as the address holds it: a link shows the same pairs
  const ranges = rangesOf({ range: kept });
  if (to > from && (from > low || to < high)) ranges[name] = [from, to];
  else delete ranges[name];
  return Object.entries(ranges)
    .map(([key, ends]) => [key, ...ends].join(":"))
    .join("~");
}

/** The ends of a histogram. @param {ArrayLike<number>} all @returns {Span} */
export function span(all) {
  let [low, high] = [Infinity, -Infinity];
  for (let i = 0; i < all.length; i++) {
    low = Math.min(low, all[i]);
    high = Math.max(high, all[i]);
  }
  return [Math.floor(20 * low) / 20, Math.ceil(20 * high) / 20];
}

/** Show what is searched for. */
export function showFound() {
  const count = scene.facts.pairs?.looks_like.filter(Boolean).length ?? 0;
  const search = $(".finder input[type=search]");
  if (search.value !== state.find) search.value = state.find;
  $(".finder .alike").hidden = !count;
  $(".alike input").checked = state.alike === "1";
  $(".alike small").textContent = `(${count})`;
}

/** Show the filters that the data allow. */
export function show() {
  const { unseen } = scene.facts;
  showFound();
  if (!unseen) return;
  const rows = HISTOGRAMS.map((row) => ({ ...row, span: span(unseen.pairs[row.name]) }));
  put(
    $(".histograms"),
    html`${rows.map(
      ({ name, title, help, span: [low, high] }) =>
        html`<figure data-name="${name}" title="${help}"><figcaption>${title} <button class="link" hidden>clear</button></figcaption>
      <svg viewBox="0 0 ${BINS} ${HIGH}" preserveAspectRatio="none" role="slider" tabindex="0" aria-label="${title}: drag to keep a range; arrows move its lower end, Shift and arrows its upper end" aria-valuemin="${low}" aria-valuemax="${high}" aria-valuenow="${low}"></svg>
      <span class="ends"><small>${low.toFixed(2)}</small><small>${high.toFixed(2)}</small></span></figure>`,
    )}`,
  );
  for (const { name, span } of rows) listen($(`.histograms [data-name=${name}]`), name, span);
  count();
}

/** @param {Found} figure @param {string} name @param {Span} span */
function listen(figure, name, span) {
  const svg = figure.querySelector("svg");
  const [low, high] = span;
  const keep = (/** @type {Span | null} */ range) => change({ range: ranged(state.range, name, span, range) });
  const at = (/** @type {PointerEvent} */ { clientX }) => {
    const box = svg.getBoundingClientRect();
    return low + Math.max(0, Math.min(1, (clientX - box.left) / box.width)) * (high - low);
  };
  let from = low;
  svg.onpointerdown = (/** @type {PointerEvent} */ event) => {
    svg.setPointerCapture(event.pointerId);
    from = at(event);
  };
  svg.onpointermove = (/** @type {PointerEvent} */ event) => {
    const to = at(event);
    if (event.buttons) keep([Math.min(from, to), Math.max(from, to)]);
  };
  svg.onkeydown = (/** @type {KeyboardEvent} */ event) => {
    const by = UP[event.key];
    if (!by) return;
    event.preventDefault();
    keep(shifted(rangesOf(state)[name], span, by, event.shiftKey));
  };
  figure.querySelector("button").onclick = () => keep(null);
}

/** Draw the kept pairs and show their number. */
export function count() {
  const { frames, facts } = scene;
  const { unseen } = facts;
  if (!unseen) return;
  const seen = (/** @type {number} */ pair) => shown(pair) || shown(frames.pairs + pair);
  let kept = 0;
  for (let pair = 0; pair < frames.pairs; pair++) if (seen(pair)) kept += 1;
  $(".finder .found").textContent = kept === frames.pairs ? "" : `${kept} of ${frames.pairs} pairs shown`;
  for (const figure of all(".histograms figure")) {
    /** @type {"confidence" | "cosine"} */
    const name = figure.dataset.name;
    const svg = figure.querySelector("svg");
    const whole = span(unseen.pairs[name]);
    const counts = histogram(unseen.pairs[name], whole);
    const most = Math.max(1, ...counts);
    const bars = (/** @type {number[]} */ counts) =>
      counts
        .map((n, i) => (n ? `M${i + 0.08} ${HIGH}V${HIGH - (n / most) * (HIGH - 2)}H${i + 0.92}V${HIGH}Z` : ""))
        .join("");
    const range = rangesOf(state)[name];
    put(
      svg,
      html`<path class="all" d="${bars(counts)}"/><path class="kept" d="${bars(histogram(unseen.pairs[name], whole, seen))}"/>`,
    );
    figure.querySelector("button").hidden = !range;
    svg.setAttribute("aria-valuenow", (range ?? whole)[0].toFixed(2));
    svg.setAttribute("aria-valuetext", range ? `${range[0].toFixed(2)} to ${range[1].toFixed(2)}` : "all");
  }
}
