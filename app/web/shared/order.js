/** The bar for p: slider, play button, and the learned p. */

import { orderText } from "./frames.js";
import { change, state } from "./store.js";

const FINE = 0.001; // step of the slider, fine enough for any learned p
const FAR = 10; // stops of Page Up and Page Down

export function orderBar(bar, frames) {
  const $ = (selector) => bar.querySelector(selector);
  const slider = $(".order");
  const play = $(".play");
  let playing = false;
  let orders = frames.orders;

  const go = (stop) => change({ p: orders[Math.max(0, Math.min(orders.length - 1, stop))] });
  slider.addEventListener("input", () => go(frames.stop(+slider.value)));
  slider.addEventListener("keydown", (event) => {
    const by = {
      ArrowRight: 1,
      ArrowUp: 1,
      ArrowLeft: -1,
      ArrowDown: -1,
      PageUp: FAR,
      PageDown: -FAR,
      Home: -orders.length,
      End: orders.length,
    }[event.key];
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

  function replace(finer) {
    frames = finer;
    orders = finer.orders;
    [slider.min, slider.max] = [Math.min(0, orders[0]), Math.max(1, orders.at(-1))];
    slider.step = FINE;
  }
  /** Show the learned p. */
  function learned(p) {
    $(".learned").hidden = !Number.isFinite(p);
    const [low, high] = [+slider.min, +slider.max];
    $(".learned-mark").hidden = !(p >= low && p <= high);
    if (!Number.isFinite(p)) return;
    $(".learned").textContent = `learned p = ${p.toFixed(3)}`;
    $(".learned").title = "Go to the learned order";
    $(".learned").onclick = () => go(frames.stop(p));
    bar.style.setProperty("--at", (p - low) / (high - low));
  }
  replace(frames);
  learned(frames.meta.head?.learned_order ?? NaN);

  return {
    learned,
    replace,
    show(stop) {
      const text = orderText(orders[stop]);
      if (Math.abs(+slider.value - orders[stop]) >= FINE / 2) slider.value = orders[stop];
      slider.setAttribute("aria-valuetext", `p ${text}`);
      $(".order-value").textContent = text;
    },
  };
}
