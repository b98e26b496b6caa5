/** Controls of Explore, connected to the page and to the address. */

import { change, openChapter, state, watch, watchIn } from "../shared/store.js";
import { openTab } from "../shared/tabs.js";
import { onClick, press } from "../shared/view.js";
import { chapterNamed } from "./chapters.js";
import { share, showLink } from "./saving.js";

/** Connect the controls of Explore, and react to changes of the address. */
export function wire(page, board) {
  const { $ } = page;
  listenToTools($, board);
  listenToChapters($, board);
  onClick($(".card"), {
    ".open": () => openTab("pair"),
    ".unpin": () => board.acts.pick(-1),
    ".find": ({ dataset }) => board.acts.near(+dataset.of),
  });
  const open = (action) => () => page.chapter === state.chapter && page.chapter && action(); // its set is there
  const on = (names, action) => watch(names, open(action));
  watch(["chapter"], () => page.enter());
  watchIn(
    "explore",
    ["p", "rung"],
    open(() => board.showOrder()),
  );
  on(["stage"], () => board.showStage());
  on(["map"], () => board.showStage());
  on(["colour", "domain", "class", "modality"], () => board.showColours());
  on(["find", "alike"], () => {
    board.finder.show();
    board.refilter();
  });
  on(["range"], () => board.refilter());
  on(["cell"], () => board.scene.facts.unseen && board.strangers.follow());
  on(["mode"], () => page.modes.follow());
  on(["reading"], () => {
    if (board.scene.only) board.strangers.choose(null);
    board.strangers.show();
    board.showLesson();
  });
  on(["pin"], () => {
    board.showCard();
    board.maps.paintMarks();
  });
  on(["means"], () => board.showMeans());
}

/** Connect the tools above the map. */
function listenToTools($, board) {
  $(".colouring").onchange = (event) => change({ colour: event.target.value });
  $(".in").onclick = () => board.maps.now.zoomBy(1.4);
  $(".out").onclick = () => board.maps.now.zoomBy(1 / 1.4);
  $(".reset").onclick = () => board.maps.now.resetView();
  $(".lasso").onclick = () => press($(".lasso"), (board.lassoMode = !board.lassoMode));
  $(".tool.means").onclick = () => change({ means: state.means === "1" ? "" : "1" });
}

/** The chapters, the lecture and the share button. */
function listenToChapters($, board) {
  onClick($(".chapters"), { "[data-chapter]": ({ dataset }) => openChapter(dataset.chapter) });
  $(".next").onclick = () => {
    openChapter(chapterNamed(state.chapter).to);
    $(".explore").scrollIntoView({ block: "start" });
  };
  $(".share").onclick = async () => {
    $(".share").textContent = await share(board.saving);
    showLink($(".shared"));
    setTimeout(() => ($(".share").textContent = "Share"), 2500);
  };
  const lecture = () => press($(".lecture"), document.body.classList.toggle("lecturing"));
  $(".lecture").onclick = lecture;
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    const typing = /** @type {HTMLElement} */ (target).closest?.("input:not([type=range]), select, textarea");
    if (typing || event.ctrlKey || event.metaKey || event.altKey || state.view !== "explore") return;
    if (key.toLowerCase() === "f" || (key === "Escape" && document.body.classList.contains("lecturing"))) lecture();
  });
}
