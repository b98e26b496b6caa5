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

const BAR = html`<div class="track"><input class="order" type="range" step="${FINE}" aria-label="Fractional order p"><span class="learned-mark" hidden></span></div>
  <button class="play main" aria-pressed="false" aria-label="Play p from 0 to 1" title="Play (space bar on this button)">▶</button>
  <label><i>p</i> = <output class="order-value">0.50</output></label>
  <button class="learned" title="Go to the learned order" hidden></button>`;

/** Make the bar; `frames` are the stops of p. @param {Found} bar @param {Stops} frames */
export function orderBar(bar, frames = HUNDREDTHS) {
  put(bar, BAR);
  /** @param {string} selector @returns {Found} */
  const $ = (selector) => bar.querySelector(selector);
  const slider = $(".order");
  const play = $(".play");
  let playing = false;
  let { orders } = frames;

  /** @param {number} stop */
  const go = (stop) => change({ p: orders[Math.max(0, Math.min(orders.length - 1, stop))] });
  slider.addEventListener("input", () => go(frames.stop(+slider.value)));
  slider.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    const by = KEYS[event.key];
    if (!by || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    go(frames.stop(state.p) + by);
  });

  function step() {
    if (!playing || !bar.isConnected) return;
    change({ p: orders[(frames.stop(state.p) + 1) % orders.length] });
    requestAnimationFrame(() => setTimeout(() => requestAnimationFrame(step), orders.length > 50 ? 20 : 220));
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
    orders = finer.orders;
    [slider.min, slider.max] = [Math.min(0, orders[0]), Math.max(1, ...orders.slice(-1))];
  }
  /** Show the learned p. @param {number} p */
  function learned(p) {
    const known = Number.isFinite(p);
    const [low, high] = [+slider.min, +slider.max];
    $(".learned").hidden = !known;
    $(".learned-mark").hidden = !(p >= low && p <= high);
    $(".learned").textContent = known ? `learned p = ${p.toFixed(3)}` : "";
    $(".learned").onclick = () => go(frames.stop(p));
    bar.style.setProperty("--at", (p - low) / (high - low));
  }
  replace(frames);

  return {
    learned,
    replace,
    /** @param {number} stop */
    show(stop) {
      const text = orderText(orders[stop]);
      if (Math.abs(+slider.value - orders[stop]) >= FINE / 2) slider.value = orders[stop];
      slider.setAttribute("aria-valuetext", `p ${text}`);
      $(".order-value").textContent = text;
    },
  };
}
