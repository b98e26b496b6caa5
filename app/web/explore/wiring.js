/** Controls of Explore, connected to the page and to the address. */

import { change, openChapter, state, watch, watchIn } from "../shared/store.js";
import { openTab } from "../shared/tabs.js";
import { chapterNamed } from "./chapters.js";
import { share, showLink } from "./saving.js";

/** Connect the controls of Explore, and react to changes of the address. */
export function wire(page) {
  listenToTools(page);
  listenToChapters(page);
  const { $ } = page;
  $(".card").onclick = (event) => {
    if (event.target.matches(".open")) openTab("pair");
    if (event.target.matches(".unpin")) page.acts.pick(-1);
    if (event.target.matches(".find")) page.acts.near(+event.target.dataset.of);
  };
  const open = (action) => () => page.chapter === state.chapter && page.chapter && action(); // its set is there
  const on = (names, action) => watch(names, open(action));
  watch(["chapter"], () => page.enter());
  watchIn(
    "explore",
    ["p", "rung"],
    open(() => page.showOrder()),
  );
  on(["stage"], () => page.showStage());
  on(["map"], () => page.showStage());
  on(["colour", "domain", "class", "modality"], () => page.showColours());
  on(["find", "alike"], () => {
    page.finder.show();
    page.refilter();
  });
  on(["range"], () => page.refilter());
  on(["cell"], () => page.scene.facts.unseen && page.strangers.follow());
  on(["mode"], () => page.modes.follow());
  on(["reading"], () => {
    if (page.scene.only) page.strangers.choose(null);
    page.strangers.show();
    page.showLesson();
  });
  on(["pin"], () => {
    page.showCard();
    page.maps.paintMarks();
  });
  on(["means"], () => page.showMeans());
}

/** Connect the tools above the map. */
function listenToTools(page) {
  const { $ } = page;
  $(".colouring").onchange = (event) => change({ colour: event.target.value });
  $(".in").onclick = () => page.maps.now.zoomBy(1.4);
  $(".out").onclick = () => page.maps.now.zoomBy(1 / 1.4);
  $(".reset").onclick = () => page.maps.now.resetView();
  $(".lasso").onclick = () => {
    page.lassoMode = !page.lassoMode;
    $(".lasso").setAttribute("aria-pressed", page.lassoMode);
  };
  $(".tool.means").onclick = () => change({ means: state.means === "1" ? "" : "1" });
}

/** The chapters, the lecture and the share button. */
function listenToChapters(page) {
  const { $ } = page;
  $(".chapters").onclick = (event) => {
    const { chapter } = event.target.closest("button")?.dataset ?? {};
    if (chapter) openChapter(chapter);
  };
  $(".next").onclick = () => {
    openChapter(chapterNamed(state.chapter).to);
    $(".explore").scrollIntoView({ block: "start" });
  };
  $(".share").onclick = async () => {
    $(".share").textContent = await share(page.saving);
    showLink($(".shared"));
    setTimeout(() => ($(".share").textContent = "Share"), 2500);
  };
  const lecture = () => {
    const on = document.body.classList.toggle("lecturing");
    $(".lecture").setAttribute("aria-pressed", on);
  };
  $(".lecture").onclick = lecture;
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    const typing = /** @type {HTMLElement} */ (target).closest?.("input:not([type=range]), select, textarea");
    if (typing || event.ctrlKey || event.metaKey || event.altKey || state.view !== "explore") return;
    if (key.toLowerCase() === "f" || (key === "Escape" && document.body.classList.contains("lecturing"))) lecture();
  });
}
