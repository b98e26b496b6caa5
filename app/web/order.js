/** The bar that moves p: slider, play, and where training left it. */

import { change, state } from "./store.js";

export function orderBar(bar, frames) {
  const $ = (selector) => bar.querySelector(selector);
  const slider = $(".order");
  const play = $(".play");
  let playing = false;
  let orders = frames.orders;

  slider.addEventListener("input", () => change({ p: orders[frames.stop(+slider.value)] }));

  function step() {
    if (!playing || !bar.isConnected) return;
    const next = frames.stop(state.p) + 1;
    change({ p: orders[next % orders.length] });
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
    slider.min = orders[0];
    slider.max = orders.at(-1);
    slider.step = orders.length > 1 ? +(orders[1] - orders[0]).toFixed(6) : 1;
  }
  /** Say where training left p. */
  function learned(p) {
    if (!Number.isFinite(p)) return;
    const inside = p >= orders[0] && p <= orders.at(-1);
    $(".learned").hidden = false;
    $(".learned").textContent = `learned p = ${p.toFixed(3)}`;
    $(".learned").title = "Go to the stop nearest to the order that training arrived at";
    $(".learned").onclick = () => change({ p: orders[frames.stop(p)] });
    $(".learned-mark").hidden = !inside;
    $(".learned-mark").style.setProperty("--at", (p - orders[0]) / (orders.at(-1) - orders[0]));
  }
  replace(frames);
  learned(frames.meta.head?.learned_order);

  return {
    learned,
    replace,
    show(stop) {
      const p = orders[stop];
      if (+slider.value !== p) slider.value = p;
      slider.setAttribute("aria-valuetext", `p ${p.toFixed(2)}`);
      $(".order-value").textContent = p.toFixed(2);
    },
  };
}
