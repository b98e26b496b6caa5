/** The state, shared by all tabs and kept in the address, so that a link restores it. */

import { COLOURINGS } from "./palette.js";
import { STAGES } from "./stages.js";

/** The tabs from the server; a saved page has Explore only. */
const VIEWS = document.querySelector("meta[name=omnivat-views]")?.getAttribute("content").split(" ") ?? [
  "explore",
];

const DEFAULTS = {
  view: "explore",
  part: "curves",
  mode: "",
  reading: "fused",
  gap: "modality_gap",
  alike: "",
  find: "",
  range: "", // histogram:from:to, joined by ~
  cell: "", // of the confusion matrix: truth~predicted~domain
  p: null,
  stage: "f_hat",
  map: "pca",
  colour: "domain",
  domain: "",
  class: "",
  modality: "",
  pin: null,
  vis: null,
  tac: null,
  p2: null,
  stage2: "raw",
  head: "",
  head2: "",
  only: "",
  only2: "",
  means: "1",
  tree: "",
};
const NUMBERS = new Set(["p", "p2", "pin"]);
const KEYS = STAGES.map((stage) => stage.key);
const CHOICES = {
  // allowed values in the address; all others are ignored
  view: VIEWS,
  part: ["curves", "strangers", "toy"],
  mode: ["", "trained", "moved", "every"],
  reading: ["fused", "vis", "tac"],
  gap: ["modality_gap", "domain_gap"],
  alike: ["", "1"],
  stage: KEYS,
  stage2: KEYS,
  map: ["pca", "umap"],
  colour: Object.keys(COLOURINGS),
};
const listeners = new Set();
let writing = 0;

function fromAddress() {
  const chosen = { ...DEFAULTS };
  for (const [name, text] of new URLSearchParams(location.search)) {
    if (!Object.hasOwn(DEFAULTS, name) || CHOICES[name]?.includes(text) === false) continue;
    if (!NUMBERS.has(name)) chosen[name] = text.slice(0, 200);
    else if (text !== "" && Number.isFinite(Number(text))) chosen[name] = Number(text);
  }
  if (!(Number.isInteger(chosen.pin) && chosen.pin >= 0)) chosen.pin = null;
  return chosen;
}

export const state = fromAddress();

/** Change values, notify listeners, and update the address after a short pause. */
export function change(patch) {
  const changed = Object.keys(patch).filter((name) => state[name] !== patch[name]);
  if (!changed.length) return;
  Object.assign(state, patch);
  for (const listener of [...listeners]) listener(changed);
  clearTimeout(writing);
  writing = setTimeout(writeAddress, 150);
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

function writeAddress() {
  const address = new URL(location.href);
  for (const [name, usual] of Object.entries(DEFAULTS)) {
    const value = state[name];
    if (value === null || value === usual) address.searchParams.delete(name);
    else address.searchParams.set(name, typeof value === "number" ? +value.toFixed(4) : value);
  }
  try {
    history.replaceState(history.state, "", address);
  } catch {
    /* a page opened from disk may not write its address in every browser */
  }
}

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
