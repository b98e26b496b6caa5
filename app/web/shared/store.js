/** The state, shared by all tabs and kept in the address, so that a link restores it. */

import { COLOURINGS } from "./palette.js";
import { afterwards } from "./ready.js";
import { STAGES } from "./stages.js";
import { OWN_MODE, TABLES } from "./tables.js";

/** The tabs from the server; a saved page has Explore only. */
const VIEWS = document.querySelector("meta[name=omnivat-views]")?.getAttribute("content")?.split(" ") ?? ["explore"];

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
  sel: "", // selected points, see acts.js
  rung: "0", // what is moved in the second chapter: "1" the mean, "2" the spread too, "p" the order
  p: null,
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
  panel: "", // one that a link opens
  means: "",
};
/** Views of earlier links, and what shows it now. */
const MOVED = {
  tree: { view: "explore", chapter: "analyse", panel: "nodes" },
  compare: { view: "explore", chapter: "analyse", beside: "1" },
  data: { view: "pair", panel: "loading" },
};
/** The chapters of Explore, and what each opens with where it differs from the workbench. */
export const CHAPTERS = {
  touch: { reading: "tac" },
  where: { map: "pca" },
  order: { map: "pca", colour: "class" },
  fooled: { mode: OWN_MODE, colour: "correctness" },
  analyse: {},
};
const RENAMED = { failure: "where" }; // chapters of earlier links
const OWN = ["mode", "alike", "find", "range", "cell", "sel", "rung", "p", "stage", "map", "colour"];
OWN.push("reading", "press", "from", "dots", "known");
OWN.push("domain", "class", "modality", "pin", "means"); // what each chapter has for itself
const LONG = { sel: 4000, vis: 2000, tac: 2000 }; // letters of a value in the address; 200 of any other
const NUMBERS = new Set(["p", "p2", "pin"]);
const KEYS = STAGES.map((stage) => stage.key);
const CHOICES = {
  // allowed values in the address; all others are ignored
  view: VIEWS,
  mode: ["", ...TABLES.modes.map(({ id }) => id)],
  reading: ["fused", "vis", "tac"],
  alike: ["", "1"],
  dots: ["", "1"],
  rung: ["0", "1", "2", "p"],
  known: ["0", "5", "20", "50", "200"],
  stage: KEYS,
  stage2: KEYS,
  map: ["pca", "umap"],
  colour: Object.keys(COLOURINGS),
};
/** Address of a picture -> its reference once it was sent, so that a link to pictures stays one. */
export const links = new Map();
const listeners = new Set();
const left = new Map(); // chapter -> its values when it was left
let otherP = null; // of the other tabs while the first chapter is open, and its own while they are

const usual = (chapter) => ({ ...DEFAULTS, ...CHAPTERS[chapter] });

function fromAddress() {
  const address = new URLSearchParams(location.search);
  if (address.has("tab")) address.set("view", address.get("tab") ?? "");
  for (const [name, value] of Object.entries(MOVED[address.get("view") ?? ""] ?? {})) address.set(name, value);
  const named = RENAMED[address.get("chapter") ?? ""] ?? address.get("chapter");
  const tools = [...address.keys()].some((name) => OWN.includes(name)); // a link to the workbench
  const chapter = Object.hasOwn(CHAPTERS, named ?? "") ? named : tools ? "analyse" : "";
  const chosen = { ...usual(chapter), chapter };
  for (const [name, text] of address) {
    if (name === "chapter" || !Object.hasOwn(DEFAULTS, name) || CHOICES[name]?.includes(text) === false) continue;
    if (!NUMBERS.has(name)) chosen[name] = links.get(text) ?? text.slice(0, LONG[name] ?? 200);
    else if (text !== "" && Number.isFinite(Number(text))) chosen[name] = Number(text);
  }
  const row = /^row:(\d+)$/.exec(chosen.panel === "nodes" ? (chosen.vis ?? "") : "");
  if (row) chosen.pin ??= Number(row[1]); // the tree of a pair was a view of its own
  if (!(Number.isInteger(chosen.pin) && chosen.pin >= 0)) chosen.pin = null;
  return chosen;
}

export const state = fromAddress();

const tell = (changed) => {
  for (const listener of [...listeners]) listener(changed);
};

/** Change values, notify listeners, and update the address after a short pause. A new tab or chapter is a
 * step that the browser's Back goes back. */
export function change(patch) {
  const changed = Object.keys(patch).filter((name) => state[name] !== patch[name]);
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

/** Open a chapter of Explore as it was left, or with its usual values. */
export function openChapter(chapter, patch = {}) {
  if (state.chapter === chapter) return change(patch);
  const pick = (from) => Object.fromEntries(OWN.map((name) => [name, from[name]]));
  if (state.chapter) left.set(state.chapter, pick(state));
  return change({ ...pick(usual(chapter)), ...left.get(chapter), ...patch, chapter });
}

/** The order at which a chapter opens; the first chapter's waits while another tab is open. */
export function openAt(p) {
  state.opened = p;
  if (state.chapter === "order" && state.view !== "explore") otherP = p;
  else state.p = p;
}

/** Back and forward: take the values of the address. `open(view)` opens a tab. */
export function followHistory(open) {
  addEventListener("popstate", () => {
    const now = fromAddress();
    const changed = Object.keys(now).filter((name) => state[name] !== now[name]);
    Object.assign(state, now);
    if (changed.includes("view")) open(state.view);
    tell(changed);
  });
}

/** Call `action` whenever one of `names` changes. Returns a function that stops it. */
export function watch(names, action) {
  const listener = (changed) => {
    if (changed.some((name) => names.includes(name))) action();
  };
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/** Like `watch`, for one tab: changes wait until the tab is open. */
export function watchIn(view, names, action) {
  let late = false;
  const now = () => {
    late = state.view !== view;
    if (!late) action();
  };
  watch(names, now);
  watch(["view"], () => late && now());
}

/** Write the state into the address now; a change waits a little, so that a drag writes once. */
export function writeAddress(how = "replaceState") {
  const address = new URL(location.href);
  address.searchParams.delete("tab");
  const from = new Map([...links].map(([link, ref]) => [ref, link]));
  for (const [name, value] of Object.entries(usual(state.chapter))) {
    const now = from.get(state[name]) ?? state[name];
    if (now === null || now === value) address.searchParams.delete(name);
    else address.searchParams.set(name, typeof now === "number" ? +now.toFixed(4) : now);
  }
  try {
    history[how](history.state, "", address);
  } catch {
    /* a page opened from disk may not write its address in every browser */
  }
}

const writeSoon = afterwards(writeAddress, 150);

const TILDE = { "%": "%25", "~": "%7E" }; // names are joined by ~ and may contain one
const packed = (name) => name.replace(/[%~]/g, (sign) => TILDE[sign]);
const unpacked = (text) => text.replace(/%25|%7E/g, (code) => (code === "%25" ? "%" : "~"));

/** The hidden names of a filter, as a set. */
export const hidden = (kind) => new Set(state[kind] ? state[kind].split("~").map(unpacked) : []);

/** Hide or show one name of a filter. */
export function toggle(kind, name) {
  const names = hidden(kind);
  if (!names.delete(name)) names.add(name);
  change({ [kind]: [...names].map(packed).join("~") });
}
