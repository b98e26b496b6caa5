/** The state, shared by all tabs and kept in the address, so that a link restores it. */

import { COLOURINGS } from "./palette.js";
import { afterwards } from "./ready.js";
import { BY_ORDER, OWN_MODE, PLACES, TABLES } from "./tables.js";

/** The tabs from the server; a saved page has Explore only. */
const VIEWS = document.querySelector("meta[name=omnivat-views]")?.getAttribute("content")?.split(" ") ?? ["explore"];

/** @type {State} */
const DEFAULTS = {
  view: "explore",
  chapter: "", // resolved when the set is known
  mode: "",
  reading: "fused",
  press: "", // of the twins: a number of those shown; the chapter chooses one
  from: "0", // the domain that a head learned from
  dots: "", // "1": filled
  known: "0", // pictures of the new sensor, without labels
  alike: "",
  find: "",
  range: "", // histogram:from:to, joined by ~
  cell: "", // of the confusion matrix: truth~predicted~domain
  sel: "", // selected points, see scene.js
  rung: PLACES[0]?.id ?? "", // what is moved in the second chapter
  p: /** @type {any} */ (null), // until the frames are there
  stage: "f_hat",
  map: "umap",
  colour: "domain",
  domain: "",
  class: "",
  modality: "",
  pin: null,
  vis: null,
  tac: null,
  p2: null,
  stage2: "raw",
  head2: "",
  beside: "", // whether the second map is open
  means: "",
};
/** The chapters of Explore, and what each opens with where it differs from the workbench.
 * @type {Record<string, Partial<State>>} */
const CHAPTERS = {
  touch: { reading: "tac" },
  where: { map: "pca" },
  order: { map: "pca", colour: "class" },
  fooled: { mode: OWN_MODE, colour: "correctness" },
  analyse: {},
};
/** What is the same in all chapters; each has the rest for itself. */
const SHARED = ["view", "chapter", "vis", "tac", "p2", "stage2", "head2", "beside"];
const OWN = Object.keys(DEFAULTS).filter((name) => !SHARED.includes(name));
const LONGEST = 4000; // letters of a value in the address
const NUMBERS = new Set(["p", "p2", "pin"]);
const KEYS = TABLES.stages.map(({ id }) => id);
/** Allowed values in the address; all others are ignored. @type {Record<string, string[]>} */
const CHOICES = {
  view: VIEWS,
  mode: ["", ...TABLES.modes.map(({ id }) => id)],
  reading: ["fused", "vis", "tac"],
  alike: ["", "1"],
  dots: ["", "1"],
  rung: [...PLACES.map(({ id }) => id), BY_ORDER],
  stage: KEYS,
  stage2: KEYS,
  map: ["pca", "umap"],
  colour: Object.keys(COLOURINGS),
};
/** Address of a picture -> its reference once it was sent, so that a link to pictures stays one.
 * @type {Map<string, Ref>} */
export const links = new Map();
/** @type {Set<(changed: string[]) => void>} */
const listeners = new Set();
/** @type {Map<string, Partial<State>>} */
const left = new Map(); // chapter -> its values when it was left
let otherP = DEFAULTS.p; // of the other tabs while the first chapter is open, and its own while they are

/** @param {string} chapter @returns {State} */
const usual = (chapter) => ({ ...DEFAULTS, ...CHAPTERS[chapter] });

/** The values of the address. @returns {State} */
function fromAddress() {
  const address = new URLSearchParams(location.search);
  const named = address.get("chapter") ?? "";
  const tools = OWN.some((name) => address.has(name)); // a link to the workbench
  const chapter = Object.hasOwn(CHAPTERS, named) ? named : tools ? "analyse" : "";
  /** @type {Record<string, string | number>} */
  const chosen = { chapter };
  for (const [name, text] of address) {
    if (name === "chapter" || !Object.hasOwn(DEFAULTS, name) || CHOICES[name]?.includes(text) === false) continue;
    if (!NUMBERS.has(name)) chosen[name] = links.get(text) ?? text.slice(0, LONGEST);
    else if (text !== "" && Number.isFinite(Number(text))) chosen[name] = Number(text);
  }
  if (!(Number.isInteger(chosen.pin) && +chosen.pin >= 0)) delete chosen.pin;
  return { ...usual(chapter), ...chosen };
}

export const state = fromAddress();

/** The names of the values that differ from the state's. @param {Partial<State>} patch */
const changes = (patch) =>
  /** @type {(keyof State)[]} */ (Object.keys(patch)).filter((name) => state[name] !== patch[name]);

/** @param {string[]} changed */
const tell = (changed) => {
  for (const listener of [...listeners]) listener(changed);
};

/** Change values, notify listeners, and update the address after a short pause. A new tab or chapter is a
 * step that the browser's Back goes back. @param {Partial<State>} patch */
export function change(patch) {
  const changed = changes(patch);
  if (!changed.length) return;
  if (changed.includes("view") && state.chapter === "order" && [state.view, patch.view].includes("explore")) {
    patch = { ...patch, p: otherP }; // p of the first chapter's own set means nothing to the head of the other tabs
    otherP = state.p;
    changed.push("p");
  }
  const step = changed.includes("view") || (changed.includes("chapter") && state.chapter !== "");
  if (step) writeAddress();
  Object.assign(state, patch);
  tell(changed);
  if (step) writeAddress("pushState");
  else writeSoon();
}

/** Open a chapter of Explore as it was left, or with its usual values.
 * @param {string} chapter @param {Partial<State>} patch */
export function openChapter(chapter, patch = {}) {
  if (state.chapter === chapter) return change(patch);
  /** @param {State} from */
  const own = (from) => Object.fromEntries(Object.entries(from).filter(([name]) => OWN.includes(name)));
  if (state.chapter) left.set(state.chapter, own(state));
  return change({ ...own(usual(chapter)), ...left.get(chapter), ...patch, chapter });
}

/** The order at which a chapter opens; the first chapter's waits while another tab is open. @param {number} p */
export function openAt(p) {
  state.opened = p;
  if (state.chapter === "order" && state.view !== "explore") otherP = p;
  else state.p = p;
}

/** Back and forward: take the values of the address. `open(view)` opens a tab. @param {(view: string) => void} open */
export function followHistory(open) {
  addEventListener("popstate", () => {
    const now = fromAddress();
    const changed = changes(now);
    Object.assign(state, now);
    if (changed.includes("view")) open(state.view);
    tell(changed);
  });
}

/** Call `action` whenever one of `names` changes. Returns a function that stops it.
 * @param {string[]} names @param {() => unknown} action */
export function watch(names, action) {
  /** @param {string[]} changed */
  const listener = (changed) => {
    if (changed.some((name) => names.includes(name))) action();
  };
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/** Like `watch`, for one tab: changes wait until the tab is open.
 * @param {string} view @param {string[]} names @param {() => unknown} action */
export function watchIn(view, names, action) {
  let late = false;
  const now = () => {
    late = state.view !== view;
    if (!late) action();
  };
  watch(names, now);
  watch(["view"], () => late && now());
}

/** Write the state into the address now; a change waits a little, so that a drag writes once.
 * @param {"pushState" | "replaceState"} how */
export function writeAddress(how = "replaceState") {
  const address = new URL(location.href);
  const from = new Map([...links].map(([link, ref]) => [ref, link]));
  for (const [name, value] of Object.entries(usual(state.chapter))) {
    const now = state[/** @type {keyof State} */ (name)];
    if (now === undefined || now === null || now === value) address.searchParams.delete(name);
    else address.searchParams.set(name, typeof now === "number" ? `${+now.toFixed(4)}` : (from.get(now) ?? now));
  }
  try {
    history[how](history.state, "", address);
  } catch {
    /* a page opened from disk may not write its address in every browser */
  }
}

const writeSoon = afterwards(() => writeAddress(), 150);

/** The hidden names of a filter, as a set: in the state they are joined by ~, of which a name may contain one.
 * @param {Filter} kind @param {Pick<State, Filter>} address */
export const hidden = (kind, address = state) =>
  new Set(address[kind] ? address[kind].split("~").map((name) => name.replace(/%25|%7E/g, decodeURIComponent)) : []);

/** Hide or show one name of a filter. @param {Filter} kind @param {string} name */
export function toggle(kind, name) {
  const names = hidden(kind);
  if (!names.delete(name)) names.add(name);
  const packed = [...names].map((one) => one.replace(/[%~]/g, (sign) => (sign === "%" ? "%25" : "%7E")));
  change({ [kind]: packed.join("~") });
}
