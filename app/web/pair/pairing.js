/** Which pictures are one pair, by their names or by a CSV. No DOM here. */

import { cells } from "../shared/csv.js";

const TAC = new Set(["tac", "tactile", "touch", "gelsight", "gel", "digit"]);
const VIS = new Set(["vis", "visual", "vision", "photo", "rgb", "video", "surface"]);
const FILLER = new Set(["image", "img", "frame", "picture"]); // words that tell pictures apart in no way
export const isPicture = (path) => PICTURE.test(path);
const PICTURE = /\.(a?png|jpe?g?|jfif|webp|bmp|dib|tiff?|gif|p[pgn]m|tga|jp2|j2k|avif)$/i;
const LABELS = ["material", "class", "label"];

const words = (text) =>
  text
    .toLowerCase()
    .split(/[^\p{L}\p{N}]+/u)
    .filter(Boolean);
/** "vis", "tac" or "", by the last word that tells. */
const sense = (text) =>
  words(text)
    .map((word) => (TAC.has(word) ? "tac" : VIS.has(word) ? "vis" : ""))
    .findLast(Boolean) ?? "";
const plain = (text) =>
  words(text)
    .filter((word) => !TAC.has(word) && !VIS.has(word) && !FILLER.has(word))
    .join("_");

/** The modality of a picture, and the name that it shares with its partner. */
export function named(path) {
  const folders = path.replace(/\.[^./]*$/, "").split("/");
  const stem = folders.pop();
  const modality = sense(stem) || (folders.map(sense).findLast(Boolean) ?? "");
  const kept = folders.filter((folder) => !sense(folder));
  return { modality, key: [...kept, plain(stem)].join("/"), folder: kept.at(-1) ?? "" };
}

/**
 * Pairs of some files. files: [{path, file}]; table: text of a CSV with columns vis, tac, or "";
 * classes: folders with these names are labels.
 * Returns {pairs: [{name, vis, tac, label}], alone: files without a place in a pair}.
 */
export function paired(files, table, classes) {
  const pictures = files.filter(({ path }) => PICTURE.test(path));
  return table ? byTable(pictures, cells(table)) : byName(pictures, classes);
}

function byName(pictures, classes) {
  const label = new Map(classes.map((name) => [name.toLowerCase(), name]));
  const found = new Map();
  const alone = [];
  for (const one of pictures) {
    const { modality, key, folder } = named(one.path);
    const pair = found.get(key) ?? { name: key, vis: null, tac: null, label: label.get(folder.toLowerCase()) ?? "" };
    if (!modality || pair[modality]) alone.push(one);
    else found.set(key, Object.assign(pair, { [modality]: one.file }));
  }
  return { pairs: [...found.values()], alone };
}

/** @param {any[]} pictures @param {string[][]} table */
function byTable(pictures, [head = [], ...rows]) {
  const column = (names) => head.findIndex((name) => names.includes(name.toLowerCase()));
  const [vis, tac, label] = [["vis"], ["tac"], LABELS].map(column);
  const used = new Set();
  const file = (path = "") => {
    const wanted = path.replaceAll("\\", "/").replace(/^(\.?\/)+/, "");
    const one =
      wanted &&
      pictures.find((p) => p.path === wanted || p.path.endsWith(`/${wanted}`) || p.path === wanted.split("/").at(-1));
    if (one) used.add(one);
    return one ? one.file : null;
  };
  const pairs = rows
    .map((row) => ({
      name: row[vis] || row[tac] || "",
      vis: file(row[vis]),
      tac: file(row[tac]),
      label: row[label] ?? "",
    }))
    .filter((pair) => pair.vis || pair.tac);
  return { pairs, alone: pictures.filter((one) => !used.has(one)) };
}
