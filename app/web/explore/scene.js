/** Values derived from the state of Explore and from the address. No DOM here. */

import { shownBy } from "../shared/filters.js";
import { classOf, domainOf } from "../shared/frames.js";
import { IMAGES } from "../shared/images.js";
import { featuresOf, INPUT } from "../shared/stages.js";
import { hidden } from "../shared/store.js";
import { base64, bytesOf } from "../shared/text.js";
import { tagOf } from "./tags.js";

export const UNSEEN = "unseen";
/** @type {{name: "confidence" | "cosine", title: string, help: string}[]} */
export const HISTOGRAMS = [
  {
    name: "confidence",
    title: "Confidence",
    help: "probability of the predicted class, both images, at the learned p",
  },
  { name: "cosine", title: "Photo–touch cosine", help: "cosine of the photo’s and the touch’s F̂, each seen alone" },
];

/** Return whether p was dragged over all stops of the frames.
 * @type {(scene: Pick<Scene, "frames" | "dragged">) => boolean} */
export function whole({ frames, dragged }) {
  const [from, to] = dragged.get(frames) ?? [];
  return from === 0 && to === frames.orders.length - 1;
}

/** Return the predictions of the last chapter's reading if that is one image alone; else null, for those of the frames.
 * @type {(scene: Scene, address: Pick<State, "chapter" | "reading">) => Numbers | null} */
export const answers = ({ facts }, { chapter, reading }) =>
  (chapter === "fooled" && reading !== "fused" && facts.unseen?.pairs.answers[reading]) || null;

/** Return whether a point passes every filter; of a reading of one image alone, those of the other do not.
 * @type {(scene: Scene, address: State) => Wanted} */
export function wantedPoints(scene, address) {
  const { frames, facts, cell } = scene;
  const shown = shownBy(frames, address);
  const alone = answers(scene, address) && address.reading;
  const alike = address.alike === "1" ? facts.pairs?.looks_like : null;
  const words = address.find.trim().toLowerCase().split(/\s+/);
  const text = (/** @type {number} */ pair) =>
    [facts.pairs?.name[pair], tagOf(frames, pair), pair, classOf(frames, pair), domainOf(frames, pair)]
      .join(" ")
      .toLowerCase();
  const ranges = HISTOGRAMS.flatMap(({ name }) => {
    const [values, range] = [facts.unseen?.pairs[name], rangesOf(address)[name]];
    return values && range ? [{ values, range }] : [];
  });
  return (point) => {
    const pair = point % frames.pairs;
    return (
      shown(point) &&
      (!alone || alone === IMAGES[+(point >= frames.pairs)]) &&
      alike?.[pair] !== "" &&
      (!cell || cell.pairs.has(pair)) &&
      ranges.every(({ values, range }) => values[pair] >= range[0] && values[pair] <= range[1]) &&
      words.every((word) => !word || text(pair).includes(word))
    );
  };
}

/** Return the pairs of unseen domains that are scored, and those of them that look like another class; none before they
 * are known.
 * @type {(scene: Pick<Scene, "frames" | "facts">) => Record<"strange" | "alike", number[]>} */
export function strangePairs({ frames, facts: { unseen, pairs } }) {
  const source = frames.domains.indexOf(unseen?.source ?? "");
  const all = Array.from(unseen && pairs ? frames.label : [], (_, pair) => pair);
  const strange = all.filter((pair) => unseen?.pairs.counts[pair] && frames.domain[pair] !== source);
  return { strange, alike: strange.filter((pair) => pairs?.looks_like[pair]) };
}

/** Return frames with what colours and cards read beside them: the columns of the pairs, and what one image alone
 * predicts.
 * @type {(scene: Scene, address: Pick<State, "chapter" | "reading">, frames?: Frames) => Frames} */
export const painted = (scene, address, frames = scene.frames) =>
  Object.assign(Object.create(frames), { columns: scene.facts.pairs ?? {}, answered: answers(scene, address) });

/** Return the names that a filter leaves. @type {(kind: Filter, names: string[], address: State) => string[]} */
function left(kind, names, address) {
  const hides = hidden(kind, address);
  return names.filter((name) => !hides.has(name));
}

/** Return the kept ranges of the histograms. @type {(address: Pick<State, "range">) => Record<string, Span>} */
export function rangesOf({ range }) {
  /** @type {Record<string, Span>} */
  const ranges = {};
  for (const part of range.split("~")) {
    const [name, from, to, ...more] = part.split(":");
    const known = HISTOGRAMS.some((histogram) => histogram.name === name) && !more.length;
    if (known && Number.isFinite(+from) && Number.isFinite(+to)) ranges[name] = [+from, +to];
  }
  return ranges;
}

/** Return the only domain that the filters leave; "" if there are several.
 * @type {(scene: Pick<Scene, "frames">, address: State) => string} */
export function loneDomain({ frames }, address) {
  const [domain, ...more] = left("domain", frames.domains, address);
  return domain && !more.length ? domain : "";
}

/** Return the active filters, in words; [] for none. @type {(scene: Scene, address: State) => string[]} */
export function filtering({ frames, facts, cell }, address) {
  /** @type {(kind: Filter, names: string[], many: string) => string} */
  const listed = (kind, names, many) => {
    const some = left(kind, names, address);
    if (some.length === names.length) return "";
    return some.length > 2 ? `${some.length} ${many}` : some.join(", ") || `no ${kind}`;
  };
  const find = address.find.trim();
  const ranges = rangesOf(address);
  return [
    listed("domain", frames.domains, "domains"),
    listed("class", frames.classes, "classes"),
    address.alike === "1" && facts.pairs && "look-alikes",
    cell?.words,
    find && `“${find}”`,
    ...HISTOGRAMS.map(
      ({ name, title }) =>
        ranges[name] && `${title.toLowerCase()} ${ranges[name].map((end) => end.toFixed(2)).join(" to ")}`,
    ),
  ].flatMap((words) => words || []);
}

/** Return the next point that the filters leave. @type {(scene: Scene, by: number) => number} */
export function nextPoint({ mask, hovered }, by) {
  for (let i = 1; i <= mask.length; i++) {
    const point = (Math.max(hovered, -1) + by * i + 2 * mask.length) % mask.length;
    if (mask[point]) return point;
  }
  return hovered;
}

/** Return the stage whose neighbours are known: of features, those of the loaded head alone.
 * @type {(scene: Scene, address: State) => string} */
export const nearStage = ({ frames }, { stage }) => (frames.foreign ? INPUT : featuresOf(stage));

/** Return what neighbours belong to: set, pair, stage and p. @type {(scene: Scene, address: State) => string} */
export const nearKey = (scene, address) =>
  `${scene.set} ${address.pin} ${nearStage(scene, address)} ${scene.frames.orders[scene.stop]}`;

/** Return the neighbours of the pinned pair if they are of this step and p; [] if not.
 * @type {(scene: Scene, address: State) => Nearest["points"]} */
export const near = (scene, address) =>
  scene.nearest && scene.nearest.key === nearKey(scene, address) ? scene.nearest.points : [];

/** Return whether a point is drawn in full colour. @type {(scene: Scene, point: number) => boolean} */
export function lit({ frames, highlight, selected }, point) {
  if (!highlight) return !selected.size || selected.has(point);
  const pair = point % frames.pairs;
  const names = {
    domain: domainOf(frames, pair),
    class: classOf(frames, pair),
    modality: point < frames.pairs ? "VIS" : "TAC",
  };
  return names[highlight.kind] === highlight.name;
}

/** Return whether the second map is open.
 * @type {(scene: Scene, address: Pick<State, "beside" | "chapter">) => boolean} */
export const isDouble = ({ frames }, { beside, chapter }) =>
  beside === "1" && chapter === "analyse" && !frames.headless;

const MOST = 2000; // letters; a longer selection is left out of the address

/** Return selected points as a text for the address: runs of neighbours, each by its ends, or "~" and a bit for each
 * point, whichever is shorter.
 * @param {Iterable<number>} points */
export function packed(points) {
  /** @type {Span[]} */
  const runs = [];
  for (const point of [...points].sort((a, b) => a - b)) {
    const last = runs.at(-1);
    if (last && last[1] === point - 1) last[1] = point;
    else runs.push([point, point]);
  }
  const listed = runs.map(([from, to]) => (to > from ? `${from}.${to}` : from)).join("-");
  const bits = new Uint8Array(((runs.at(-1)?.[1] ?? 0) >> 3) + 1);
  for (const [from, to] of runs) for (let point = from; point <= to; point++) bits[point >> 3] |= 1 << (point & 7);
  const text =
    listed.length < Math.max(60, 1.4 * bits.length)
      ? listed
      : `~${base64(bits).replaceAll("+", "-").replaceAll("/", "_")}`;
  return text.length > MOST ? "" : text;
}

/** Return the points below `count` that a packed text lists; none for a text of another form.
 * @param {string} text @param {number} count */
export function unpacked(text, count) {
  /** @type {number[]} */
  const points = [];
  if (text.startsWith("~")) {
    const letters = /^~((?:[\w-]{4})*[\w-]{0,3})=*$/.exec(text)?.[1].replaceAll("-", "+").replaceAll("_", "/") ?? "";
    const bits = bytesOf(letters.length % 4 === 1 ? "" : letters);
    const all = Array.from({ length: Math.min(count, 8 * bits.length) }, (_, point) => point);
    return all.filter((point) => bits[point >> 3] & (1 << (point & 7)));
  }
  let next = 0;
  for (const run of text.split("-")) {
    const [from, to = from] = run.split(".").map((part) => Number.parseInt(part, 10));
    if (!(from >= next && to < count)) return points;
    for (next = from; next <= to; next++) points.push(next);
  }
  return points;
}
