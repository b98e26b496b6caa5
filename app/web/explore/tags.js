/** Words that a visitor gives to pairs. The browser remembers them for each set; a CSV saves and loads them. */

import { Refusal } from "../shared/api.js";
import { cells, csv } from "../shared/csv.js";
import { classOf } from "../shared/frames.js";
import { keep, keptJson } from "../shared/memory.js";

const LONGEST = 40; // letters of a tag
/** Name of a set -> pair -> tag. @type {Map<string, Map<number, string>>} */
const sets = new Map();

/** @param {Frames} frames */
const nameOf = ({ meta, pairs }) => {
  const { weights_hash = "", origin = "" } = meta.embeddings ?? {};
  return `omnivat-tags ${pairs} ${weights_hash} ${origin} ${meta.domains?.join() ?? ""}`;
};

/** @param {Frames} frames */
function tagsOf(frames) {
  const name = nameOf(frames);
  const tags = sets.get(name) ?? new Map(keptJson(name, []));
  sets.set(name, tags);
  return tags;
}

/** @param {Frames} frames @param {number} pair */
export const tagOf = (frames, pair) => tagsOf(frames).get(pair) ?? "";

/** Give pairs a tag; "" takes theirs away. @param {Frames} frames @param {number[]} pairs @param {string} tag */
export function tagPairs(frames, pairs, tag) {
  const tags = tagsOf(frames);
  for (const pair of pairs) tag ? tags.set(pair, tag.slice(0, LONGEST)) : tags.delete(pair);
  keep(nameOf(frames), JSON.stringify([...tags]));
}

/** Return one line for each pair with a tag. @param {Frames} frames @param {string[]} [names] */
export const tagsCsv = (frames, names) =>
  csv([
    ["pair", "name", "class", "tag"],
    ...[...tagsOf(frames)].map(([pair, tag]) => [pair, names?.[pair] ?? "", classOf(frames, pair), tag]),
  ]);

/** Take the tags of a CSV with the columns pair and tag; returns how many pairs have one now. Throws a Refusal.
 * @param {Frames} frames @param {string} text */
export function loadTags(frames, text) {
  const [head = [], ...rows] = cells(text);
  const [pair, tag] = ["pair", "tag"].map((name) => head.indexOf(name));
  if (pair < 0 || tag < 0)
    throw new Refusal("This file has no columns 'pair' and 'tag'; save tags here to see what they look like.");
  const known = rows.filter((row) => /^\d+$/.test(row[pair]) && +row[pair] < frames.pairs && row[tag]);
  if (!known.length) throw new Refusal("No line of this file has a tag for a pair of this set.");
  for (const row of known) tagPairs(frames, [+row[pair]], row[tag].replace(/^'(?=[=+\-@])/, ""));
  return known.length;
}
