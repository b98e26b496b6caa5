/** Controls of Explore, connected to what they do; and what is drawn when the address changes. */

import { openChapter, watch, watchIn, writeAddress } from "../shared/store.js";
import { openTab } from "../shared/tabs.js";
import { onClick, press, tell } from "../shared/view.js";
import * as beside from "./beside.js";
import * as board from "./board.js";
import * as gaps from "./gaps.js";
import { tagListed } from "./grid.js";
import { map } from "./maps.js";
import * as nodes from "./nodes.js";
import { enter, followMode } from "./page.js";
import { addressOf } from "./panels.js";
import { $, change, percent, scene, send, state } from "./root.js";
import { loadFile, saveAs, share, showLink } from "./saving.js";
import { showSteps } from "./staircase.js";
import { chooseCell, chooseStranger, show as showStrangers } from "./strangers.js";
import * as threads from "./threads.js";
import * as touch from "./touch.js";

/** Return whether the board's map is on the screen; the first chapter has none, the third another one. */
const isMapped = () => !["touch", "where"].includes(state.chapter);
const shownMap = () => (isMapped() ? map : threads.cloud);

/** What a click does, by what is clicked. @type {Record<string, (button: Found) => unknown>} */
const CLICKS = {
  "button[data-chapter]": ({ dataset, classList }) => {
    openChapter(dataset.chapter);
    if (classList.contains("main")) $().scrollIntoView({ block: "start" });
  },
  ".share": async (button) => {
    if ($(".play").ariaPressed === "true") $(".play").click(); // what is shared stays on the screen
    writeAddress();
    button.textContent = await share(map !== undefined && isMapped());
    showLink();
    setTimeout(() => (button.textContent = "Share"), 2500);
  },
  ".lecture": lecture,
  "[data-set][aria-pressed=false]": ({ dataset }) => location.assign(addressOf(dataset.set, location.href)),
  "[data-choice]": ({ dataset }) => change({ [dataset.choice]: dataset.key }),
  "[data-stage]": ({ dataset }) => change({ stage: dataset.stage }),
  ".in": () => shownMap().zoomBy(1.4),
  ".out": () => shownMap().zoomBy(1 / 1.4),
  ".reset": () => shownMap().resetView(),
  ".lasso": (button) => press(button, send("lassoSwitched", {}).lasso),
  "[data-switch]": ({ dataset }) => toggle(dataset.switch),
  "[data-save]": ({ dataset }) => saveAs(dataset.save),
  ".card .open, .try-own": () => openTab("pair"),
  ".unpin": () => board.pick(-1),
  ".find": ({ dataset }) => board.findNear(+dataset.of),
  "[data-pair]": ({ dataset }) => board.pick(+dataset.pair),
  "[data-point]": ({ dataset }) => board.pick(+dataset.point),
  ".clear": () => board.select([]),
  "[data-truth]": ({ dataset }) => chooseCell(+dataset.truth, +dataset.answer),
  ".sensors button": ({ dataset }) => threads.chooseSensor(+dataset.domain),
};

/** What another value of a field does, at its end and while it is typed or moved.
 * @type {Record<"change" | "input", Record<string, (field: Found) => unknown>>} */
const FIELDS = {
  change: {
    "[data-value]": ({ dataset, value }) => change({ [dataset.value]: value }),
    ".alike input": () => toggle("alike"),
    ".of-head": ({ value: by }) => change({ by }),
    ".of-steps": ({ value: stairs }) => {
      send("arrived", { stairs });
      showSteps();
    },
    ".of-domain": ({ value }) => chooseStranger(value),
    ".tagging": ({ value }) => tagListed(value.trim()),
    ".load-tags input": loadFile,
  },
  input: {
    "[type=search]": ({ value }) => change({ find: value.slice(0, 80) }),
    ".its-p": ({ value }) => beside.moveTo(+value),
  },
};

/** @param {"alike" | "means" | "beside"} name */
const toggle = (name) => change({ [name]: state[name] === "1" ? "" : "1" });

/** Show map, chart and control alone, or all again. */
function lecture() {
  press($(".lecture"), document.body.classList.toggle("lecturing"));
}

/** The names whose change draws something on the board, and what. @type {[string[], () => unknown][]} */
const DRAWN = [
  [["stage", "map"], board.showStage],
  [["colour", "domain", "class", "modality"], board.showColours],
  [["find", "alike", "range"], board.refilter],
  [["cell"], board.followCell],
  [["sel"], board.followSelection], // once the points of the address are shown
  [["mode"], followMode],
  [["reading"], board.showReading],
  [["pin"], board.showCard],
  [["pin"], nodes.follow],
  [["pin"], board.announcePairSoon],
  [["pin"], board.paintMarks],
  [["pin", "vis", "tac", "map"], () => state.chapter === "gaps" && gaps.follow()],
  [["beside"], board.resetMaps],
  [["beside", "means"], board.showMeans],
  [["head2"], beside.load],
  [["p2", "stage2", "head2"], beside.show],
];

/** Connect the controls and the address. */
export function wire() {
  board.buildBar();
  onClick($(), CLICKS);
  for (const kind of ["pointerover", "focusin"])
    $().addEventListener(kind, (/** @type {At} */ { target }) => {
      if (scene.chapter === "touch") touch.show(+(target.closest(".twin")?.dataset.domain ?? -1));
    });
  for (const [kind, acts] of Object.entries(FIELDS))
    $().addEventListener(kind, (/** @type {{target: Found}} */ { target }) => {
      for (const [selector, act] of Object.entries(acts)) if (target.matches(selector)) act(target);
    });
  addEventListener("resize", () => scene.chapter === "fooled" && showStrangers()); // its pictures share the width
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    const typing = /** @type {HTMLElement} */ (target).closest?.("input:not([type=range]), select, textarea");
    if (typing || event.ctrlKey || event.metaKey || event.altKey || state.view !== "explore") return;
    if (key.toLowerCase() === "f" || (key === "Escape" && document.body.classList.contains("lecturing"))) lecture();
  });
  document.addEventListener("omnivat:arriving", (event) => {
    const { path, share } = /** @type {CustomEvent} */ (event).detail;
    const awaited = /^(frames|twins)/.test(path) && !$().classList.contains("ready"); // other tabs load, too
    if (awaited) tell($(".wait"), `Loading this chapter: ${percent(share)}`);
  });
  watch(["chapter", "by"], enter);
  watch(["press", "from", "dots", "known", "reading"], () => scene.chapter === "touch" && touch.show());
  watch(["rung", "map", "press", "reading", "dots"], () => scene.chapter === "where" && threads.show());
  const isThere = () => scene.chapter === state.chapter && scene.chapter !== "" && isMapped(); // its set is there
  watchIn("explore", ["p"], () => isThere() && board.showOrder());
  for (const [names, draw] of DRAWN) watch(names, () => isThere() && draw());
}
