/** Frames: exact map positions for every stop of p, and the curves. A map is fetched when it is first shown, the
 * present stop first. */

import { address, get, inSet, Refusal, refused } from "./api.js";
import { fileOf, held } from "./held.js";
import { keeper } from "./once.js";
import { awaited } from "./ready.js";
import { featuresOf } from "./stages.js";
import { has, OWN_MODE } from "./tables.js";
import { bytesOf, NO_CLASS } from "./text.js";

const MAGIC = "OVFRAMES";
const TRIES = 3; // of an array whose connection is lost midway
const ARRAYS = { u8: Uint8Array, u16: Uint16Array };
/** An array: its values, and which of its stops have come.
 * @typedef {{values: Uint8Array | Uint16Array, there: boolean[]}} Part */
/** What fetches an array, of a map from one of its stops outward.
 * @typedef {(name: string, from: number) => Promise<Response>} Fetch */

export class Frames {
  /** @param {FramesMeta} meta @param {Fetch | null} [fetchPart] @param {[string, Uint8Array][]} [there] the arrays that
   * are there */
  constructor(meta, fetchPart = null, there = []) {
    this.meta = meta;
    this.fetchPart = fetchPart;
    this.orders = meta.orders;
    this.pairs = meta.pairs;
    this.domains = meta.domains;
    this.classes = meta.classes;
    this.once = keeper();
    this.base = this; // what is fetched belongs to these frames, also by way of what inherits from them
    /** @type {Set<() => void>} */
    this.arrivals = new Set(); // called whenever something has come
    /** @type {Map<string, Part>} */
    this.parts = new Map();
    for (const [name, bytes] of there) {
      const part = this.part(name);
      new Uint8Array(part.values.buffer).set(bytes);
      part.there.fill(true);
    }
    this.domain = this.array("domain");
    this.label = this.array("label");
    this.prediction = this.array("prediction");
    this.confidence = this.array("confidence"); // empty until it has come
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

  /** The frames in a file. @param {ArrayBuffer} buffer */
  static in(buffer) {
    const magic = new TextDecoder().decode(new Uint8Array(buffer, 0, 8));
    if (magic !== MAGIC) throw new Refusal("This is not a frames file of this version; make it again.");
    const length = new DataView(buffer).getUint32(8, true);
    /** @type {FramesMeta} */
    const meta = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 12, length)));
    const start = 12 + length; // offsets of arrays count from the end of the JSON
    const all = Object.entries(meta.arrays).map(([name, { offset, dtype, shape }]) => {
      const size = shape.reduce((a, b) => a * b, ARRAYS[dtype].BYTES_PER_ELEMENT);
      return /** @type {[string, Uint8Array]} */ ([name, new Uint8Array(buffer, start + offset, size)]);
    });
    return new Frames(meta, null, all);
  }

  /** The frames of a head part; their predictions come with it. @param {FramesMeta} meta @param {Fetch} fetchPart */
  static async of(meta, fetchPart) {
    const inline = Object.entries(meta.inline ?? {}).map(
      ([name, text]) => /** @type {[string, Uint8Array]} */ ([name, bytesOf(text)]),
    );
    const frames = new Frames(meta, fetchPart, inline);
    await frames.load("prediction");
    return frames;
  }

  /** Room for an array. @param {string} name @returns {Part} */
  part(name) {
    const there = this.parts.get(name);
    if (there) return there;
    const { shape, dtype } = this.meta.arrays[name];
    const count = shape.reduce((a, b) => a * b, 1);
    const made = { values: new ARRAYS[dtype](count), there: new Array(shape.length === 3 ? shape[0] : 1).fill(false) };
    this.parts.set(name, made);
    return made;
  }

  /** An array that has come as a whole; else an empty one. @param {string} name */
  array(name) {
    const part = this.parts.get(name);
    return part?.there.every(Boolean) ? part.values : new Uint8Array();
  }

  /** Fetch an array once, of a map the stop `from` first. @param {string} name @returns {Promise<void>} */
  load(name, from = 0) {
    return this.once(name, () => awaited(this.base.fetched(name, from)));
  }

  /** An array, requested again if the connection is lost midway. @param {string} name @param {number} from */
  async fetched(name, from) {
    for (let tries = 0; this.fetchPart; tries++) {
      try {
        await this.read(name, from, await this.fetchPart(name, from));
        break;
      } catch (error) {
        if (error instanceof Refusal || tries === TRIES) throw error;
      }
    }
    this.prediction = this.array("prediction");
    this.confidence = this.array("confidence");
    if (name.startsWith("map:")) this.load("confidence").catch(() => {});
    this.tell();
  }

  /** Read an array while it comes. @param {string} name @param {number} from @param {Response} response */
  async read(name, from, response) {
    const { values, there } = this.part(name);
    const bytes = new Uint8Array(values.buffer);
    const size = bytes.length / there.length;
    const order = [...there.keys()].sort((a, b) => Math.abs(a - from) - Math.abs(b - from) || a - b);
    const reader = /** @type {ReadableStream<Uint8Array>} */ (response.body).getReader();
    let [come, reported] = [0, 0]; // bytes
    for (let { value, done } = await reader.read(); !done; { value, done } = await reader.read()) {
      for (let at = 0; value && at < value.length; ) {
        const [place, inside] = [Math.floor(come / size), come % size];
        const some = value.subarray(at, at + size - inside);
        if (place >= order.length) throw new Refusal("The frames that came are of another size; reload the page.");
        bytes.set(some, order[place] * size + inside);
        at += some.length;
        come += some.length;
        there[order[place]] = inside + some.length === size;
      }
      if (Math.floor(come / size) > reported) this.tell();
      reported = Math.floor(come / size);
    }
  }

  /** Something has come. */
  tell() {
    for (const act of this.arrivals) act();
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
      Object.fromEntries(Object.entries(all).map(([name, entry]) => [name, change(entry)]));
    /** @type {Frames} */
    const made = Object.assign(Object.create(this), {
      whole: this,
      orders: of(orders),
      prediction: Uint8Array.from(of(this.prediction, pairs)),
      meta: {
        ...meta,
        orders: of(orders),
        curves: entries(meta.curves, (curve) => of(curve)),
        maps: entries(meta.maps, mapped),
      },
    });
    const known = { from: this.confidence, rows: this.confidence };
    const rows = () => {
      if (known.from !== this.confidence || known.rows === this.confidence)
        Object.assign(known, { from: this.confidence, rows: Uint8Array.from(of(this.confidence, pairs)) });
      return known.rows;
    };
    return Object.defineProperty(made, "confidence", { get: rows });
  }

  /** The boxes around the points of a map at all stops. @param {string} name */
  extentsOf(name) {
    const known = this.meta.extents?.[name] ?? this.extents.get(name);
    if (known) return known;
    const found = boxes(this.array(name), this.pairs);
    this.extents.set(name, found);
    return found;
  }

  /** The kinds of map of a stage: "pca", "umap". @param {string} stage */
  kinds(stage) {
    const names = Object.keys(this.meta.maps).map((name) => name.split("/"));
    return names.filter(([, of]) => of === featuresOf(stage)).map(([kind]) => kind);
  }

  /** Positions at one stop of one map; `drawn` is the stop of these positions. While the map comes, they are of the
   * nearest stop that is there; null without any.
   * @param {string} kind @param {string} stage @param {number} stop @returns {Placed | null} */
  positions(kind, stage, stop) {
    const map = this.meta.maps[`${kind}/${featuresOf(stage)}`];
    const { values, there } = this.part(map.array);
    const wanted = nearest(map.orders, stop);
    if (!there[wanted]) this.load(map.array, wanted).catch((error) => refused(error, () => {}));
    const come = map.orders.map((at, i) => (there[i] ? at : Infinity));
    const index = nearest(come, stop);
    if (!there[index]) return null;
    const size = 4 * this.pairs;
    return {
      points: values.subarray(index * size, (index + 1) * size),
      drawn: map.orders[index],
      stops: map.orders.length,
      bounds: map.bounds,
      trust: map.trust?.[index],
      extents: this.extentsOf(map.array),
    };
  }

  /** The largest error of a position, as a share of its map's radius. */
  get error() {
    return Math.max(
      ...Object.values(this.meta.maps).map(
        ({ max_error, bounds: [low, high] }) => (2 * max_error) / (high[0] - low[0]),
      ),
    );
  }
}
/** @typedef {Positions & {drawn: number, stops: number}} Placed */

/** Return the index of the value nearest to one; the first of several. @param {number[]} values @param {number} to */
export const nearest = (values, to) =>
  values.reduce((best, v, i) => (Math.abs(v - to) < Math.abs(values[best] - to) ? i : best), 0);

/** Return boxes around the two halves of positions, over any number of stops.
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

/** @typedef {Pick<Frames, "domains" | "domain" | "classes" | "label">} Pairs */
/** The domain of a pair, by name. @param {Pairs} frames @param {number} pair */
export const domainOf = ({ domains, domain }, pair) => domains[domain[pair]];
/** Return the class of a pair, by name. @param {Pairs} frames @param {number} pair */
export const classOf = ({ classes, label }, pair) => classes[label[pair]];

/** p as text: two digits, or three if the stop lies between two hundredths. @param {number} p */
export const orderText = (p) => (Math.abs(p - +p.toFixed(2)) < 1e-9 ? p.toFixed(2) : p.toFixed(3));

/** @typedef {Partial<Record<"head" | "mode" | "set" | "progress" | "part" | "from" | "of", string>>} Named */
/** @param {Named} named */
const query = (named) =>
  `frames?${new URLSearchParams(Object.entries(named).filter(([, value]) => value))}`.replace(/\?$/, "");

/** @param {number} ms */
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Fetch the frames of a head, mode or set; report progress to `onWait` while the server computes them.
 * @param {(step: Step | null) => void} onWait @param {Named} named */
export const fetchFrames = (onWait, named = {}) => awaited(fetched(onWait, named));

/** Fetch frames once the server has them; until then `onWait` gets its progress.
 * @param {(step: Step | null) => void} onWait @param {Named} named */
async function fetched(onWait, named) {
  const part = query({ ...named, part: "head" });
  const inFile = held && !fileOf(held, part); // a page of one file has the whole file
  for (;;) {
    const response = await get(inFile ? query(named) : part);
    if (response.status === 200) {
      const frames = inFile ? Frames.in(await response.arrayBuffer()) : await inParts(await response.json(), named);
      frames.coarse = response.headers.get("X-Frames") === "coarse";
      return { frames, drawn: response.headers.get("X-Thumbnails") !== "none" };
    }
    onWait((await response.json()).step);
    await pause(700);
  }
}

/** @param {FramesMeta} meta @param {Named} named */
const inParts = (meta, named) =>
  Frames.of(meta, (name, from) =>
    get(query({ ...named, part: name, ...(!held && { from: String(from), of: meta.tag }) }), { whole: false }),
  );

/** Wait for finer frames after coarse ones. @param {(step: Step | null) => void} onWait @param {Named} named */
export async function whenFine(onWait, named = {}) {
  for (;;) {
    await pause(1500);
    const { step } = await (await get(query({ progress: "1", ...named }))).json();
    if (!step) return (await fetchFrames(onWait, named)).frames;
    onWait(step);
  }
}

/** Return the sheet of thumbnails of a set that has them; null in a saved page without them.
 * @returns {Promise<Sprite | null>} */
export const fetchThumbnails = (set = "") => awaited(sheet(set));

/** @param {string} set */
async function sheet(set) {
  const response = await get(inSet("thumbnails.json", set)).catch(() => null);
  if (!response) return null;
  return { ...(await response.json()), url: address(inSet("thumbnails.webp", set)) };
}
