/** Controls of Explore, connected to the page and to the address. */

import { COLOURINGS } from "../shared/palette.js";
import { change, state, watch, watchIn } from "../shared/store.js";
import { openTab } from "../shared/tabs.js";
import { escaped } from "../shared/text.js";

export const PARTS = ["curves", "strangers", "toy"];

/** Connect the controls of Explore, and react to changes of the address. */
export function wire(page) {
  listenToTools(page);
  const { $ } = page;
  $(".parts").onclick = (event) => event.target.dataset.part && change({ part: event.target.dataset.part });
  $(".parts").onkeydown = (event) => turnPart(page, event);
  $(".gap-kind").onchange = (event) => change({ gap: event.target.value });
  $(".card").onclick = (event) => {
    if (event.target.matches(".open")) openTab("pair");
    if (event.target.matches(".unpin")) page.acts.pick(-1);
    if (event.target.matches(".find")) page.acts.near(+event.target.dataset.of);
  };
  watchIn("explore", ["p"], () => page.showOrder());
  watch(["stage"], () => page.showStage());
  watch(["map"], () => {
    $(".map-kind").value = state.map;
    page.maps.showBefore();
    page.maps.showNow();
  });
  watch(["colour", "domain", "class", "modality"], () => page.showColours());
  watch(["find", "alike"], () => {
    page.finder.show();
    page.refilter();
  });
  watch(["range"], () => page.refilter());
  watch(["cell"], () => page.scene.facts.unseen && page.strangers.follow());
  watch(["part"], () => page.showPart());
  watch(["mode"], () => page.modes.follow());
  watch(["reading"], () => page.scene.only && page.strangers.choose(null));
  watch(["gap"], () => {
    $(".gap-kind").value = state.gap;
    page.balance.replace(page.scene.frames);
    page.balance.show(page.scene.stop);
  });
  watch(["pin"], () => {
    page.showCard();
    page.maps.paintMarks();
  });
  watch(["means"], () => page.showMeans());
}

/** Connect the tools above the map. */
function listenToTools(page) {
  const { $ } = page;
  $(".colouring").innerHTML = Object.entries(COLOURINGS)
    .map(([key, c]) => `<option value="${key}">${escaped(c.label)}</option>`)
    .join("");
  $(".colouring").onchange = (event) => change({ colour: event.target.value });
  $(".map-kind").onchange = (event) => change({ map: event.target.value });
  $(".gap-kind").value = state.gap;
  $(".in").onclick = () => page.maps.now.zoomBy(1.4);
  $(".out").onclick = () => page.maps.now.zoomBy(1 / 1.4);
  $(".reset").onclick = () => page.maps.each((cloud) => cloud.resetView());
  $(".lasso").onclick = () => {
    page.lassoMode = !page.lassoMode;
    $(".lasso").setAttribute("aria-pressed", page.lassoMode);
  };
  $(".tool.means").onclick = () => change({ means: state.means === "1" ? "0" : "1" });
}

/** Arrow keys on the tabs beside the map. */
function turnPart(page, event) {
  const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!by) return;
  event.preventDefault();
  const part = PARTS[(PARTS.indexOf(state.part) + by + PARTS.length) % PARTS.length];
  change({ part });
  page.$(`[data-part="${part}"]`).focus();
}
