/** The state, shared by all tabs and kept in the address, so that a link restores it. */

import { afterwards } from "./ready.js";
import { INPUT, OUTPUT } from "./stages.js";
import { OWN_MODE, PLACES, TABLES } from "./tables.js";

/** The tabs from the server; a saved page has Explore only. */
const VIEWS = document.querySelector("meta[name=omnivat-views]")?.getAttribute("content")?.split(" ") ?? ["explore"];

/** @type {Omit<State, "left" | "otherP" | "tour">} */
const DEFAULTS = {
  view: "explore",
  chapter: "", // resolved when the set is known
  mode: "",
  reading: "fused",
  press: "", // of the twins: a number of those shown; the chapter chooses one
  from: "0", // the domain that a head learned from
  dots: "", // "1": filled; "relief": touch by relief
  known: "0", // pictures of the new sensor, without labels
  alike: "",
  find: "",
  range: "", // histogram:from:to, joined by ~
  cell: "", // of the confusion matrix: truth~predicted~domain
  sel: "", // selected points, see scene.js
  rung: PLACES[0]?.id ?? "", // what is moved in the third chapter
  p: /** @type {any} */ (null), // until the frames are there
  stage: OUTPUT,
  map: "umap",
  colour: "domain",
  domain: "",
  class: "",
  modality: "",
  pin: null,
  vis: null,
  tac: null,
  by: "",
  p2: null,
  stage2: INPUT,
  head2: "",
  beside: "", // whether the second map is open
  means: "",
};
/** The chapters of Explore, and what each opens with where it differs from the workbench.
 * @type {Record<string, Partial<State>>} */
const CHAPTERS = {
  touch: { reading: "tac" },
  gaps: {},
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
  dots: ["", "1", "relief"],
  rung: PLACES.map(({ id }) => id),
  stage: KEYS,
  stage2: KEYS,
  map: ["pca", "umap"],
  colour: TABLES.colours.map(({ id }) => id),
};
/** Address of a picture -> its reference once it was sent, so that a link to pictures stays one.
 * @type {Map<string, Ref>} */
export const links = new Map();
/** @type {Set<(changed: string[]) => void>} */
const listeners = new Set();

/** @param {string} chapter @returns {Omit<State, "left" | "otherP" | "tour">} */
const usual = (chapter) => ({ ...DEFAULTS, ...CHAPTERS[chapter] });

/** Return the values of the address. @returns {Omit<State, "left" | "otherP" | "tour">} */
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

/** The state, which `change` alone replaces. @type {Readonly<State>} */
export let state = Object.freeze({ ...fromAddress(), left: {}, otherP: DEFAULTS.p, tour: -1 });

/** Return the state after values have changed. p of the chapter of the order, which has a set of its own, means nothing
 * to the head of the other tabs: each side finds its own again.
 * @param {Readonly<State>} before @param {Partial<State>} patch @returns {State} */
export function after(before, patch) {
  const { chapter, view, p, otherP } = before;
  const { view: opened = view } = patch;
  const crosses = chapter === "order" && opened !== view && [view, opened].includes("explore");
  return { ...before, ...patch, ...(crosses && { p: otherP, otherP: p }) };
}

/** Take another state, and call who watches what is new in it. @param {State} next
 * @param {(changed: string[]) => void} [first] */
function become(next, first = () => {}) {
  const changed = Object.entries(next).flatMap(([name, value]) =>
    state[/** @type {keyof State} */ (name)] === value ? [] : name,
  );
  if (!changed.length) return changed;
  first(changed);
  state = Object.freeze(next);
  for (const listener of [...listeners]) listener(changed);
  return changed;
}

/** Change values, notify listeners, and update the address after a short pause. A new tab or chapter is a
 * step that the browser's Back goes back. @param {Partial<State>} patch */
export function change(patch) {
  let step = false;
  const changed = become(after(state, patch), (changed) => {
    step = changed.includes("view") || (changed.includes("chapter") && state.chapter !== "");
    if (step) writeAddress();
  });
  if (step) writeAddress("pushState");
  else if (changed.length) writeSoon();
}

/** Open a chapter of Explore as it was left, or with its usual values.
 * @param {string} chapter @param {Partial<State>} patch */
export function openChapter(chapter, patch = {}) {
  if (state.chapter === chapter) return change(patch);
  /** @param {Partial<State>} from */
  const own = (from) => Object.fromEntries(Object.entries(from).filter(([name]) => OWN.includes(name)));
  const left = state.chapter ? { ...state.left, [state.chapter]: own(state) } : state.left;
  return change({ ...own(usual(chapter)), ...left[chapter], ...patch, chapter, left });
}

/** Return the order at which a chapter opens; that of the order's own set waits while another tab is open.
 * @param {number} p */
export const openAt = (p) => change(state.chapter === "order" && state.view !== "explore" ? { otherP: p } : { p });

/** Back and forward: take the values of the address. An address that was left before p was known changes no p, unless
 * its chapter opens anew. `open(view)` opens a tab. @param {(view: string) => void} open */
export function followHistory(open) {
  addEventListener("popstate", () => {
    const { view, chapter, p } = state;
    const next = fromAddress();
    if (next.chapter === chapter) next.p ??= p;
    become({ ...state, ...next });
    if (state.view !== view) open(state.view);
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
    const now = state[/** @type {keyof typeof DEFAULTS} */ (name)];
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

/** Return the hidden names of a filter, as a set: in the state they are joined by ~, of which a name may contain one.
 * @param {Filter} kind @param {Pick<State, Filter>} address */
export const hidden = (kind, address = state) =>
  new Set(address[kind] ? address[kind].split("~").map((name) => name.replace(/%25|%7E/g, decodeURIComponent)) : []);

/** Hide or show one name of a filter. @param {Filter} kind @param {string} name */
export function toggle(kind, name) {
  const names = hidden(kind);
  if (!names.delete(name)) names.add(name);
  const packed = [...names].map((entry) => entry.replace(/[%~]/g, (sign) => (sign === "%" ? "%25" : "%7E")));
  change({ [kind]: packed.join("~") });
}
