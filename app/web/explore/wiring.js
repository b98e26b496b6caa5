/** Controls of Explore, connected to the page and to the address. */

import { change, openChapter, state, watch, watchIn, writeAddress } from "../shared/store.js";
import { openTab } from "../shared/tabs.js";
import { onClick, press } from "../shared/view.js";
import { share, showLink } from "./saving.js";

/** Whether the board's map is on the screen; the first chapter has none, the second another one until p moves. */
const mapped = () => state.chapter !== "touch" && (state.chapter !== "where" || state.rung === "p");

/** Connect what every chapter has: the way from one to the next, Share and Lecture; and the first chapter. */
export function wire(page) {
  const { $ } = page;
  watch(["chapter"], () => page.enter());
  watch(["press", "from", "dots", "known", "reading"], () => page.chapter === "touch" && page.touch.show());
  watch(["rung", "map", "press", "reading", "dots"], () => state.chapter === "where" && page.threads.show());
  onClick($(".explore"), {
    "button[data-chapter]": ({ dataset, classList }) => {
      openChapter(dataset.chapter);
      if (classList.contains("main")) $(".explore").scrollIntoView({ block: "start" });
    },
  });
  $(".share").onclick = async () => {
    if ($(".play").ariaPressed === "true") $(".play").click(); // what is shared stays on the screen
    writeAddress();
    $(".share").textContent = await share(page.board && mapped() ? page.board.saving : null);
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

/** Connect the map and what is beside it, and react to changes of the address. */
export function wireBoard(page, board) {
  const { $ } = page;
  listenToTools($, board);
  onClick($(".card"), {
    ".open": () => openTab("pair"),
    ".unpin": () => board.acts.pick(-1),
    ".find": ({ dataset }) => board.acts.near(+dataset.of),
  });
  const there = () => page.chapter === state.chapter && !["", "touch"].includes(page.chapter); // its set is there
  const open = (action) => () => there() && action();
  const on = (names, action) => watch(names, open(action));
  watchIn(
    "explore",
    ["p", "rung"],
    open(() => board.showOrder()),
  );
  on(["p"], () => state.chapter === "where" && change({ rung: "p" }));
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
    board.read();
    board.showLesson();
  });
  on(["pin"], () => {
    board.showCard();
    board.nodes.follow();
    board.maps.paintMarks();
  });
  on(["means"], () => board.showMeans());
  on(["beside"], () => {
    board.maps.reset();
    board.showMeans();
  });
  on(["head2"], () => board.maps.beside.load());
  on(["p2", "stage2", "head2"], () => board.maps.beside.show());
}

/** Connect the tools above the map. */
function listenToTools($, board) {
  $(".colouring").onchange = (event) => change({ colour: event.target.value });
  const shown = () => (mapped() ? board.maps.now : board.threads.cloud);
  $(".in").onclick = () => shown().zoomBy(1.4);
  $(".out").onclick = () => shown().zoomBy(1 / 1.4);
  $(".reset").onclick = () => shown().resetView();
  $(".lasso").onclick = () => press($(".lasso"), (board.lassoMode = !board.lassoMode));
  $(".tool.second").onclick = () => change({ beside: state.beside === "1" ? "" : "1" });
  $(".tool.means").onclick = () => change({ means: state.means === "1" ? "" : "1" });
}
