/** Colours and shapes. Domains use the hues of Okabe and Ito, classes those of Tol's bright
 * scheme. Both are safe for colour-blind readers, and they differ from each other. */

import { has, TABLES } from "./tables.js";
import { grouped } from "./text.js";

const OKABE_ITO = ["#e69f00", "#56b4e9", "#009e73", "#d55e00", "#0072b2", "#cc79a7", "#f0e442", "#8c8c8c"];
const TOL_BRIGHT = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#aa3377", "#66ccee", "#bbbbbb", "#332288"];
const CIVIDIS = ["#00224e", "#27406f", "#575d6d", "#7d7c78", "#a59c74", "#d2c060", "#fee838"];

export const VIS_COLOUR = "#56b4e9";
export const TAC_COLOUR = "#e69f00";
export const isLecture = () => document.body.classList.contains("lecturing");
export const isDark = () => document.body.classList.contains("dark");

/** Call `action` when the page switches between light and dark, or to a lecture. @param {() => void} action */
export function onTheme(action) {
  new MutationObserver(action).observe(document.body, { attributeFilter: ["class"] });
}

/** @param {number} index */
export const domainColour = (index) => OKABE_ITO[index % OKABE_ITO.length];
/** @param {number} index */
export const classColour = (index) => TOL_BRIGHT[index % TOL_BRIGHT.length];

/** @typedef {Omit<Colouring, keyof ColourRow>} Grouping */
/** A colour for each value of the pairs: the index of each, and the names in their order.
 * @param {(f: Colourable) => Numbers} values @param {(f: Colourable) => string[]} names
 * @param {(index: number) => string} colour @returns {Grouping} */
const byValue = (values, names, colour) => ({
  values,
  groups: (f) => names(f).map((name, i) => [name, colour(i)]),
  of: (f) => {
    const index = values(f);
    return (pair) => index[pair];
  },
});

const MOST = TOL_BRIGHT.length; // values of a column that have a colour each
/** @typedef {{index: number[], names: string[]}} Values */
/** @type {WeakMap<string[], Values>} */
const known = new WeakMap();

/** Return the values of a column of the pairs' table; of more than MOST, the most frequent and the others.
 * @param {string[]} column @returns {Values} */
function valuesIn(column) {
  const found = known.get(column);
  if (found) return found;
  /** @type {Map<string, number>} */
  const counts = new Map();
  for (const value of column) counts.set(value, (counts.get(value) ?? 0) + 1);
  const others = counts.size > MOST && counts.size - (MOST - 1);
  const frequent = [...counts].sort(([, a], [, b]) => b - a).slice(0, others ? MOST - 1 : MOST);
  const values = frequent.map(([value]) => value).sort();
  const place = new Map(values.map((value, i) => [value, i]));
  const names = values.map((value) => value || "none");
  const made = {
    index: column.map((value) => place.get(value) ?? values.length),
    names: others ? [...names, `${grouped(others)} other values`] : names,
  };
  known.set(column, made);
  return made;
}

/** @type {string[]} */
const NONE = [];
/** @param {string} column @returns {Grouping} */
const byColumn = (column) =>
  byValue(
    ({ columns }) => valuesIn(columns[column] ?? NONE).index,
    ({ columns }) => valuesIn(columns[column] ?? NONE).names,
    classColour,
  );

/** @type {Record<string, Grouping>} */
const KNOWN = {
  domain: byValue(
    (f) => f.domain,
    (f) => f.domains,
    domainColour,
  ),
  class: byValue(
    (f) => f.label,
    (f) => f.classes,
    classColour,
  ),
  modality: {
    groups: () => [
      ["VIS", VIS_COLOUR],
      ["TAC", TAC_COLOUR],
    ],
    of: () => (_, tac) => (tac ? 1 : 0),
  },
  correctness: {
    groups: () => [
      ["right", "#009e73"],
      ["wrong", "#d55e00"],
    ],
    of: (f, stop) => (pair) => (saidOf(f, pair, stop) === f.label[pair] ? 0 : 1),
  },
  confidence: {
    groups: (f) => {
      const low = 1 / f.classes.length;
      const step = (1 - low) / CIVIDIS.length;
      return CIVIDIS.map((colour, i) => [`≥ ${Math.round(100 * (low + i * step))} %`, colour]);
    },
    of: (f, stop) => {
      const from = stop * f.pairs;
      const low = 1 / f.classes.length;
      const scale = CIVIDIS.length / (1 - low);
      return (pair) => {
        const bin = Math.floor((f.confidence[from + pair] / 255 - low) * scale);
        return Math.max(0, Math.min(CIVIDIS.length - 1, bin));
      };
    },
  },
};

/** Return the class that is predicted for a pair at a stop: by one image alone where that is shown, else by the head.
 * @param {Colourable} frames @param {number} pair @param {number} stop */
export const saidOf = ({ answered, prediction, pairs }, pair, stop) =>
  answered?.[pair] ?? prediction[stop * pairs + pair];

/** Colourings of points: each has a title, names, colours, and the group of a point. @type {Colouring[]} */
const COLOURINGS = TABLES.colours.map((row) => ({ ...row, ...(row.column ? byColumn(row.column) : KNOWN[row.id]) }));

/** @param {Numbers} all */
const differ = (all) => all.some((value) => value !== all[0]);

/** Return whether frames have what a colouring needs: values that differ, a head and classes, a calibrated confidence.
 * @param {Colourable} frames @param {Colouring} row */
const fits = (frames, { needs = [], values }) =>
  (!values || differ(values(frames))) &&
  needs.every(
    (need) =>
      ({ head: !frames.headless, classes: frames.labelled })[need] ??
      (has(frames, need) && frames.confidence.length > 0),
  );

/** Return the colourings that frames have. @param {Colourable} frames */
export const colouringsOf = (frames) => COLOURINGS.filter((row) => fits(frames, row));

/** Return the colouring called `key`, or that of classes if the frames lack it, or the first.
 * @param {Colourable} frames @param {string} key */
export function colouring(frames, key) {
  const all = colouringsOf(frames);
  return all.find(({ id }) => id === key) ?? all.find(({ id }) => id === "class") ?? all[0];
}

/** @param {string} hex */
export const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));

/** Return a ramp from paper to ink for pictures of magnitudes: 256 colours as [r, g, b]. @param {boolean} dark */
export function ramp(dark) {
  const stops = (
    dark ? ["#0b1220", "#16456e", "#2f9ec4", "#f4e7a1"] : ["#ffffff", "#a9d4e6", "#2b7cb0", "#0a2342"]
  ).map(rgb);
  return Array.from({ length: 256 }, (_, i) => {
    const at = (i / 255) * (stops.length - 1);
    const low = Math.min(stops.length - 2, Math.floor(at));
    return stops[low].map((v, c) => Math.round(v + (stops[low + 1][c] - v) * (at - low)));
  });
}
