/** Which pictures are one pair, by their names or by a CSV. No DOM here. */

import { cells } from "../shared/csv.js";
import { IMAGES } from "../shared/images.js";

const TAC = new Set(["tac", "tactile", "touch", "gelsight", "gel", "digit"]);
const VIS = new Set(["vis", "visual", "vision", "photo", "rgb", "video", "surface"]);
const FILLER = new Set(["image", "img", "frame", "picture"]); // words that tell pictures apart in no way
const PICTURE = /\.(png|apng|jpg|jpeg|jpe|jfif|webp|gif|bmp|tif|tiff)$/i;
const WHOLE = "Choose the folder that holds them, so that the page sees their paths.";
const LABELS = ["material", "class", "label"];
export const LONGEST = 40; // letters of a label, as the server takes them

/** @param {string} path */
export const isPicture = (path) => PICTURE.test(path);

/** @param {string} text */
const words = (text) =>
  text
    .toLowerCase()
    .split(/[^\p{L}\p{N}]+/u)
    .filter(Boolean);
/** "vis" or "tac", by the last word of the text that names a modality, else "".
 * @param {string} text @returns {Modality | ""} */
const sense = (text) =>
  words(text)
    .map((word) => (TAC.has(word) ? "tac" : VIS.has(word) ? "vis" : ""))
    .findLast(Boolean) || "";
/** @param {string} text */
const plain = (text) =>
  words(text)
    .filter((word) => !sense(word) && !FILLER.has(word))
    .join("_");

/** The modality of a picture, and the name that it shares with its partner. @param {string} path */
export function named(path) {
  const folders = path.replace(/\.[^./]*$/, "").split("/");
  const stem = folders.pop() ?? "";
  const modality = sense(stem) || (folders.map(sense).findLast(Boolean) ?? "");
  const kept = folders.filter((folder) => !sense(folder));
  return { modality, key: [...kept, plain(stem)].join("/"), folder: kept.at(-1) ?? "" };
}

/** Pictures with what they are, photos first; those whose names do not tell are `rest`.
 * @param {Chosen[]} files @param {Modality} rest @returns {[Modality, File][]} */
export const sorted = (files, rest) =>
  IMAGES.flatMap((kind) =>
    files.flatMap(({ path, file }) =>
      isPicture(path) && (named(path).modality || rest) === kind ? [[kind, file]] : [],
    ),
  );

/**
 * Pairs of some files. table: text of a CSV with columns vis, tac, or ""; classes: folders with these names are labels;
 * rest: what pictures are whose names do not tell, if anybody said it. Returns
 * {pairs, alone: files without a place in a pair, problem}; `problem` is why nothing was paired, if names do not tell
 * which file is meant.
 * @param {Chosen[]} files @param {string} table @param {string[]} classes @param {Modality} [rest]
 * @returns {{pairs: FilePair[], alone: Chosen[], problem: string}}
 */
export function paired(files, table, classes, rest) {
  const pictures = files.filter(({ path }) => isPicture(path));
  return table ? byTable(pictures, cells(table)) : byName(pictures, classes, rest);
}

/** @param {Chosen[]} pictures @param {string[]} classes @param {Modality} [rest] */
function byName(pictures, classes, rest) {
  const label = new Map(classes.map((name) => [name.toLowerCase(), name]));
  /** @type {Map<string, FilePair>} */
  const pairs = new Map();
  const alone = [];
  for (const one of pictures) {
    const { modality: stated, key, folder } = named(one.path);
    const modality = stated || rest;
    const pair = pairs.get(key) ?? { name: key, vis: null, tac: null, label: label.get(folder.toLowerCase()) ?? "" };
    if (!modality || pair[modality]) alone.push(one);
    else pairs.set(key, { ...pair, [modality]: one.file });
  }
  return { pairs: [...pairs.values()], alone, problem: "" };
}

/** The pictures that a path of a CSV can mean: those at this path, else those known by their bare name alone.
 * @param {Chosen[]} pictures @param {string} path */
function meant(pictures, path) {
  const exact = pictures.filter((p) => p.path === path || p.path.endsWith(`/${path}`));
  return exact.length ? exact : pictures.filter((p) => p.path === path.split("/").at(-1));
}

/** @param {Chosen[]} pictures @param {string[][]} table */
function byTable(pictures, [head = [], ...rows]) {
  const [vis, tac, label] = [["vis"], ["tac"], LABELS].map((names) =>
    head.findIndex((name) => names.includes(name.toLowerCase())),
  );
  const pathOf = new Map(); // picture -> the path that the CSV gives it
  let problem = "";
  const file = (text = "") => {
    const path = text.replaceAll("\\", "/").replace(/^(\.?\/)+/, "");
    const [one, other] = path ? meant(pictures, path) : [];
    if (!one) return null;
    const before = pathOf.get(one) ?? path;
    pathOf.set(one, path);
    if (other) problem ||= `'${path}' of the CSV can be ${one.path} or another file of that name. ${WHOLE}`;
    if (before !== path) problem ||= `'${before}' and '${path}' of the CSV would be one file, ${one.path}. ${WHOLE}`;
    return one.file;
  };
  for (const row of rows)
    if (row[vis] && row[vis] === row[tac]) problem ||= `The CSV gives ${row[vis]} as photo and as touch of one pair.`;
  const pairs = rows.map((row) => ({
    name: row[vis] || row[tac] || "",
    vis: file(row[vis]),
    tac: file(row[tac]),
    label: row[label] ?? "",
  }));
  return {
    pairs: problem ? [] : pairs.filter((pair) => pair.vis || pair.tac),
    alone: pictures.filter((one) => !pathOf.has(one)),
    problem,
  };
}
