/** Read the binary of frames: exact map positions for every stop of p, and the curves. */

import { address, get, inSet, Refusal } from "./api.js";
import { awaited } from "./ready.js";
import { featuresOf } from "./stages.js";
import { has, OWN_MODE } from "./tables.js";
import { NO_CLASS } from "./text.js";

const MAGIC = "OVFRAMES";
const ARRAYS = { u8: Uint8Array, u16: Uint16Array };

export class Frames {
  /** @param {ArrayBuffer} buffer */
  constructor(buffer) {
    const magic = new TextDecoder().decode(new Uint8Array(buffer, 0, 8));
    if (magic !== MAGIC) throw new Refusal("This is not a frames file of this version; make it again.");
    const length = new DataView(buffer).getUint32(8, true);
    /** @type {FramesMeta} */
    this.meta = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 12, length)));
    this.buffer = buffer;
    this.start = 12 + length; // offsets of arrays count from the end of the JSON
    this.orders = this.meta.orders;
    this.pairs = this.meta.pairs;
    this.domains = this.meta.domains;
    this.classes = this.meta.classes;
    this.domain = this.array("domain");
    this.label = this.array("label");
    this.prediction = this.array("prediction");
    this.confidence = this.array("confidence");
    /** @type {Frames | null} */
    this.whole = null; // the frames of all stops, of which these are some
    this.coarse = false; // whether finer frames will follow
    this.by = ""; // what predicts, in words, if it is not the loaded head
    this.still = false; // whether it predicts the same at every p
    this.foreign = false; // whether they are of a mode of p whose heads the server does not hold
    /** @type {Numbers | null} */
    this.answered = null; // Explore alone gives them; what they are, see Colourable
    /** @type {Record<string, string[]>} */
    this.columns = {};
    /** @type {Map<string, Box[]>} */
    this.extents = new Map(); // array of a map -> the boxes around its VIS and its TAC points at all stops
  }

  /** The mode of p, as `tables.js` has it; "features" without a head. */
  get kind() {
    return this.meta.head?.kind ?? OWN_MODE;
  }

  /** True if no head fits the set: there are features, and no predictions. */
  get headless() {
    return this.kind === "features";
  }

  /** True if the pairs have classes. */
  get labelled() {
    return this.label.some((k) => this.classes[k] !== NO_CLASS);
  }

  /** The learned p; NaN if every stop has its own head. */
  get learned() {
    return this.meta.head?.learned_order ?? NaN;
  }

  /** [low, high]: the orders that a head of fixed weights was trained for; null if they are not known. */
  get fits() {
    return has(this, "what-if") ? (this.meta.head?.fits ?? null) : null;
  }

  /** The head's source domain; "" if unknown. */
  get source() {
    return this.meta.head?.source ?? "";
  }

  /** True if a pair is two recordings of one signal, drawn as stripes: no photo and no touch. */
  get signals() {
    return this.meta.embeddings.encoder === "strip";
  }

  /** @param {string} name */
  array(name) {
    const entry = this.meta.arrays[name];
    const count = entry.shape.reduce((a, b) => a * b, 1);
    return new ARRAYS[entry.dtype](this.buffer, this.start + entry.offset, count);
  }

  /** The stop nearest to p: an index into `orders`. @param {number} p */
  stop(p) {
    return nearest(this.orders, p);
  }

  /** The same at some of the stops, given as indices. Maps of other stops are left out. @param {number[]} stops
   * @returns {Frames} */
  only(stops) {
    const { orders, pairs, meta } = this;
    const of = (/** @type {any} */ all, wide = 1) =>
      stops.flatMap((stop) => [...all.slice(stop * wide, (stop + 1) * wide)]);
    const mapped = (/** @type {FramesMeta["maps"][string]} */ map) =>
      map.orders.length === 1
        ? map
        : { ...map, orders: map.orders.map((stop) => stops.indexOf(stop)).map((at) => (at < 0 ? Infinity : at)) };
    const entries = (/** @type {Record<string, any>} */ all, /** @type {(one: any) => any} */ change) =>
      Object.fromEntries(Object.entries(all).map(([name, one]) => [name, change(one)]));
    return Object.assign(Object.create(this), {
      whole: this,
      orders: of(orders),
      prediction: Uint8Array.from(of(this.prediction, pairs)),
      confidence: Uint8Array.from(of(this.confidence, pairs)),
      meta: {
        ...meta,
        orders: of(orders),
        curves: entries(meta.curves, (one) => of(one)),
        maps: entries(meta.maps, mapped),
      },
    });
  }

  /** @param {string} name */
  extentsOf(name) {
    let found = this.extents.get(name);
    if (!found) this.extents.set(name, (found = boxes(this.array(name), this.pairs)));
    return found;
  }

  /** The kinds of map of a stage: "pca", "umap". @param {string} stage */
  kinds(stage) {
    const names = Object.keys(this.meta.maps).map((name) => name.split("/"));
    return names.filter(([, of]) => of === featuresOf(stage)).map(([kind]) => kind);
  }

  /** Positions at one stop of one map; `drawn` is the stop of these positions.
   * @param {string} kind @param {string} stage @param {number} stop */
  positions(kind, stage, stop) {
    const map = this.meta.maps[`${kind}/${featuresOf(stage)}`];
    const index = nearest(map.orders, stop);
    const size = 4 * this.pairs;
    return {
      points: this.array(map.array).subarray(index * size, (index + 1) * size),
      drawn: map.orders[index],
      stops: map.orders.length,
      bounds: map.bounds,
      trust: map.trust?.[index],
      extents: this.extentsOf(map.array),
      error: (2 * map.max_error) / (map.bounds[1][0] - map.bounds[0][0]), // share of the radius
    };
  }
}

/** The index of the value nearest to one; the first of several. @param {number[]} values @param {number} to */
export const nearest = (values, to) =>
  values.reduce((best, v, i) => (Math.abs(v - to) < Math.abs(values[best] - to) ? i : best), 0);

/** Boxes around the two halves of positions, over any number of stops.
 * @param {Numbers} all @param {number} pairs */
function boxes(all, pairs) {
  /** @type {Box[]} */
  const halves = [
    [65535, 65535, 0, 0],
    [65535, 65535, 0, 0],
  ];
  for (let i = 0; i < all.length; i += 2) {
    const box = halves[Math.floor(i / 2 / pairs) % 2];
    box[0] = Math.min(box[0], all[i]);
    box[1] = Math.min(box[1], all[i + 1]);
    box[2] = Math.max(box[2], all[i]);
    box[3] = Math.max(box[3], all[i + 1]);
  }
  return halves;
}

/** p as text: two digits, or three if the stop lies between two hundredths. @param {number} p */
export const orderText = (p) => (Math.abs(p - +p.toFixed(2)) < 1e-9 ? p.toFixed(2) : p.toFixed(3));

/** @typedef {{head?: string, mode?: string, set?: string, progress?: string}} Named */
/** @param {Named} named */
const query = (named) =>
  `frames?${new URLSearchParams(Object.entries(named).filter(([, value]) => value))}`.replace(/\?$/, "");

/** @param {number} ms */
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Fetch the frames of a head, mode or set; report progress to `onWait` while the server computes them.
 * @param {(step: Step | null) => void} onWait @param {Named} named */
export const fetchFrames = (onWait, named = {}) => awaited(fetched(onWait, named));

/** @param {(step: Step | null) => void} onWait @param {Named} named */
async function fetched(onWait, named) {
  for (;;) {
    const response = await get(query(named));
    if (response.status === 200) {
      const frames = new Frames(await response.arrayBuffer());
      frames.coarse = response.headers.get("X-Frames") === "coarse";
      return { frames, drawn: response.headers.get("X-Thumbnails") !== "none" };
    }
    onWait((await response.json()).step);
    await pause(700);
  }
}

/** Wait for finer frames after coarse ones. @param {(step: Step | null) => void} onWait @param {Named} named */
export async function whenFine(onWait, named = {}) {
  for (;;) {
    await pause(1500);
    const { step } = await (await get(query({ progress: "1", ...named }))).json();
    if (!step) return (await fetchFrames(onWait, named)).frames;
    onWait(step);
  }
}

/** The sheet of thumbnails of a set that has them; null in a saved page without them.
 * @returns {Promise<Sprite | null>} */
export const fetchThumbnails = (set = "") => awaited(sheet(set));

/** @param {string} set */
async function sheet(set) {
  const response = await get(inSet("thumbnails.json", set)).catch(() => null);
  if (!response) return null;
  return { ...(await response.json()), url: address(inSet("thumbnails.webp", set)) };
}
