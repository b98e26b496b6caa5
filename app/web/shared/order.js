/** The bar for p: slider, play button, and the learned p. */

import { orderText } from "./frames.js";
import { change, state } from "./store.js";
import { html, put } from "./text.js";

const FINE = 0.001; // step of the slider, fine enough for any learned p
/** @typedef {{orders: number[], stop: (p: number) => number}} Stops */
/** Steps that a key moves by. @type {Record<string, number>} */
export const KEYS = {
  ...{ ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 },
  ...{ PageUp: 10, PageDown: -10, Home: -Infinity, End: Infinity },
};

/** Every hundredth, until other stops are known. */
export const HUNDREDTHS = {
  orders: Array.from({ length: 101 }, (_, i) => i / 100),
  stop: (/** @type {number} */ p) => Math.max(0, Math.min(100, Math.round(100 * p))),
};

/** Return the ends of the axis of p, whichever stops are there.
 * @param {Pick<Stops, "orders">} frames
 * @returns {[number, number]} */
export const span = ({ orders }) => [Math.min(0, orders[0]), Math.max(1, orders[orders.length - 1])];

const BAR = html`<div class="track"><input class="order" type="range" step="${FINE}" aria-label="Fractional order p">
  <span class="learned-mark" hidden></span></div>
  <button class="play main" aria-pressed="false" aria-label="Play p from 0 to 1"
    title="Play (space bar on this button)">▶</button>
  <label><i>p</i> = <output class="order-value">0.50</output></label>
  <button class="learned" title="Go to the learned order" hidden></button>`;

/** Make the bar, with every hundredth as a stop until `replace` gives others. @param {Found} bar */
export function orderBar(bar) {
  /** @type {Stops} */
  let frames = HUNDREDTHS;
  put(bar, BAR);
  /** @param {string} selector @returns {Found} */
  const $ = (selector) => bar.querySelector(selector);
  const slider = $(".order");
  const play = $(".play");
  let playing = false;

  /** @param {number} stop */
  const go = (stop) => change({ p: frames.orders[Math.max(0, Math.min(frames.orders.length - 1, stop))] });
  slider.addEventListener("input", () => go(frames.stop(+slider.value)));
  slider.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    const by = KEYS[event.key];
    if (!by || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    go(frames.stop(state.p) + by);
  });

  function step() {
    if (!playing || !bar.isConnected) return;
    const { length } = frames.orders;
    go((frames.stop(state.p) + 1) % length);
    requestAnimationFrame(() => setTimeout(() => requestAnimationFrame(step), length > 50 ? 20 : 220));
  }
  play.onclick = () => {
    playing = !playing;
    play.textContent = playing ? "❚❚" : "▶";
    play.setAttribute("aria-pressed", playing);
    step();
  };

  /** Take other stops. @param {Stops} finer */
  function replace(finer) {
    frames = finer;
    [slider.min, slider.max] = span(finer);
  }
  /** Show the learned p. @param {number} p */
  function learned(p) {
    const [low, high] = span(frames);
    $(".learned").hidden = !Number.isFinite(p);
    $(".learned-mark").hidden = !(p >= low && p <= high);
    $(".learned").textContent = `learned p = ${p.toFixed(3)}`;
    $(".learned").onclick = () => go(frames.stop(p));
    bar.style.setProperty("--at", (p - low) / (high - low));
  }
  replace(frames);

  return {
    learned,
    replace,
    /** @param {number} stop */
    show(stop) {
      const p = frames.orders[stop];
      const text = orderText(p);
      if (Math.abs(+slider.value - p) >= FINE / 2) slider.value = p;
      slider.setAttribute("aria-valuetext", `p ${text}`);
      $(".order-value").textContent = text;
    },
  };
}
