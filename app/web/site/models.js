/** The models of one set: the encoder, the heads and the embeddings, each fetched when it is first used. */

import { withoutDots } from "./dots.js";
import { Refused } from "./refusal.js";
import { inTurn, LOST, runtime } from "./runtime.js";
import { rowOf, sum, tensors } from "./tensors.js";

const SIDE = 224; // pixels that the encoder sees
const STRIPES = 64;
const NOT_HERE =
  "Pictures for this head's encoder need Python: run `python -m pip install -r requirements.txt`, then `python app.py`.";

/** @type {Map<string, Promise<any>>} */
const all = new Map(); // what every set has: the runtime
/** Remember what is on its way; a failure is tried again.
 * @template T @param {Map<string, Promise<any>>} kept @param {string} key @param {() => Promise<T>} make
 * @returns {Promise<T>} */
function once(kept, key, make) {
  if (!kept.has(key)) kept.set(key, make());
  const made = /** @type {Promise<T>} */ (kept.get(key));
  made.catch(() => kept.delete(key));
  return made;
}

export class Models {
  /** @param {string | URL} base address of the models @param {string} set its folder
   * @param {(step: Step) => void} told receives a download on its way */
  constructor(base, set, told = () => {}) {
    this.base = base;
    this.folder = new URL(`${set}/`, base);
    this.told = told;
    this.kept = new Map();
  }

  /** @template T @param {string} key @param {() => Promise<T>} make */
  once = (key, make) => once(this.kept, key, make);

  runtime = () => once(all, `${this.base}`, () => runtime(this.base, this.fetch));

  /** The bytes of a file of the models, which lies there packed; the page is told of one with a title.
   * @param {URL} url */
  fetch = async (url, title = "") => {
    const response = await fetch(`${url}.gz`).catch(() => null);
    if (!response?.ok || !response.body) throw new Refused(LOST);
    const total = Number(response.headers.get("Content-Length")) || 0;
    const parts = [];
    let done = 0;
    const tell = (/** @type {number} */ of) => title && this.told({ text: title, done, total: of });
    const reader = response.body.getReader();
    for (let next = await reader.read(); !next.done; next = await reader.read()) {
      parts.push(next.value);
      done += next.value.length;
      tell(total);
    }
    tell(done);
    const packed = new Blob(parts);
    const [a, b] = new Uint8Array(await packed.slice(0, 2).arrayBuffer());
    if (a !== 0x1f || b !== 0x8b) return packed.arrayBuffer(); // the server has unpacked it
    return new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  };

  about = () =>
    this.once("models.json", async () =>
      JSON.parse(new TextDecoder().decode(await this.fetch(new URL("models.json", this.folder)))),
    );

  /** @param {string} name */
  file = (name) => this.once(name, async () => tensors(await this.fetch(new URL(name, this.folder)), name));

  /** @param {URL} url @param {string} title */
  session = (url, title) =>
    this.once(`${url}`, async () => {
      const [{ InferenceSession }, bytes] = await Promise.all([this.runtime(), this.fetch(url, title)]);
      return inTurn(() => InferenceSession.create(new Uint8Array(bytes), { executionProviders: ["wasm"] }));
    });

  /** A head of the set: what models.json has of it, and its graph.
   * @param {string | null} [asked] @returns {Promise<SiteHead>} */
  async head(asked) {
    const name = asked ?? "";
    const head = (await this.about()).heads[name];
    if (!head) throw new Refused(`No head is called '${String(name).slice(0, 40)}' here.`);
    return { ...head, name, url: new URL(head.file, this.folder) };
  }

  /** The tensors of a part of a head's folder; null without it.
   * @param {string} name @param {"familiarity" | "profile"} part */
  async part(name, part) {
    const { parts } = await this.head(name);
    return parts[part] ? this.file(parts[part]) : null;
  }

  /** Run a graph of the set on {name: [type, values, shape]}; name -> {shape, values} of `wanted`, or of all.
   * @param {URL} url @param {string} title @param {Record<string, any[]>} feeds @param {string[]} [wanted]
   * @returns {Promise<Tensors>} */
  async ran(url, title, feeds, wanted) {
    const [{ Tensor }, session] = await Promise.all([this.runtime(), this.session(url, title)]);
    const entries = session.inputNames.map((/** @type {string} */ name) => [name, new Tensor(...feeds[name])]);
    const out = await inTurn(() => session.run(Object.fromEntries(entries), wanted ?? session.outputNames));
    const listed = Object.entries(out).map(([name, { dims, data }]) => [name, { shape: dims, values: data }]);
    return Object.fromEntries(listed);
  }

  /** Rows as a graph takes them: two or more, a missing one of zeros.
   * @param {(Floats | null | undefined)[]} rows */
  async rows(rows, least = 1) {
    const { width } = await this.about();
    const count = Math.max(least, rows.length);
    const values = new Float32Array(count * width);
    rows.forEach((row, i) => row && values.set(row, i * width));
    return ["float32", values, [count, width]];
  }

  /** Run a head on one pair of embeddings at several orders of VIS and of TAC.
   * @param {SiteHead} head @param {Rows} pair @param {[number, number][]} orders */
  async run({ url }, { vis, tac }, orders) {
    const stops = orders.length === 1 ? [...orders, ...orders] : orders; // the graph takes two or more
    const both = Float64Array.from([...stops.map(([p]) => p), ...stops.map(([, p]) => p)]);
    const feeds = { orders: ["float64", both, [2, stops.length]] };
    return this.ran(url, "the head", { ...feeds, vis: await this.rows([vis]), tac: await this.rows([tac]) });
  }

  /** The outputs `wanted` of a head's stages, for many pairs of embeddings at one order.
   * @param {SiteHead} head @param {Record<Modality, Floats[]>} pairs @param {number} order @param {string[]} wanted */
  async stages(head, pairs, order, wanted) {
    const [vis, tac] = [await this.rows(pairs.vis, 2), await this.rows(pairs.tac, 2)];
    const count = Math.max(2, pairs.vis.length);
    const orders = ["float64", new Float64Array(count).fill(order), [count]];
    return this.ran(new URL(head.stages, this.folder), "the tree", { vis, tac, orders }, wanted);
  }

  /** The picture as the encoder gets it: the dots of a gel are filled if they were in training.
   * @param {Raster} picture @param {string} modality */
  async seen(picture, modality) {
    const { encoder } = await this.about();
    return modality === "tac" && encoder?.dots === "fill" ? withoutDots(picture) : picture;
  }

  /** The embeddings of a picture as photo and as touch: two only where dots were filled. @param {Raster} picture */
  async asEither(picture) {
    const touch = await this.seen(picture, "tac");
    const vis = await this.encoded(picture);
    return { vis, tac: touch === picture ? vis : await this.encoded(touch) };
  }

  /** A picture of another size, as Pillow resizes.
   * @param {Raster} picture @param {number} wide @param {number} high @returns {Promise<Raster>} */
  async resized({ pixels, width, height }, wide, high) {
    const { resized } = await this.ran(new URL("resize.onnx", this.base), "", {
      picture: ["uint8", pixels, [1, height, width, 3]],
      shape: ["int64", BigInt64Array.of(1n, BigInt(high), BigInt(wide), 3n), [4]],
    });
    return { pixels: resized.values, width: wide, height: high };
  }

  /** The picture within `most` × `most` pixels. @param {Raster} picture @param {number} most */
  async within(picture, most) {
    const scale = most / Math.max(picture.width, picture.height);
    const side = (/** @type {number} */ length) => Math.max(1, Math.round(scale * length));
    return scale >= 1 ? picture : this.resized(picture, side(picture.width), side(picture.height));
  }

  /** The embedding of a picture, as `seen` gives it. @param {Raster} picture @returns {Promise<Float32Array>} */
  async encoded(picture) {
    const { encoder } = await this.about();
    if (!encoder) throw new Refused(NOT_HERE, 501);
    if (encoder.kind === "strip") return signalOf(picture);
    const url = new URL(encoder.file, this.base);
    const [{ pixels }] = await Promise.all([this.resized(picture, SIDE, SIDE), this.session(url, "the encoder")]);
    const out = await this.ran(url, "the encoder", { picture: ["uint8", pixels, [1, SIDE, SIDE, 3]] });
    return Object.values(out)[0].values;
  }

  /** The embedding of one image of a pair of the set. @param {number} number @param {Modality} modality */
  async row(number, modality) {
    const { part } = await this.about();
    const some = await this.file(`set-${Math.floor(number / part)}.safetensors`);
    return rowOf(some[modality], number % part);
  }
}

/** The signal of a picture of upright stripes, -1 to 1: the mean grey of the pixels with a centre in each.
 * @param {Raster} picture */
export function signalOf({ pixels, width, height }) {
  const grey = new Array(width).fill(0); // means of the columns
  for (let x = 0; x < width; x++)
    for (let y = 0, at = 3 * x; y < height; y++, at += 3 * width)
      grey[x] += ((19595 * pixels[at] + 38470 * pixels[at + 1] + 7471 * pixels[at + 2] + 0x8000) >> 16) / height;
  const reach = Math.max(1, width / STRIPES) / 2;
  return Float32Array.from({ length: STRIPES }, (_, at) => {
    const centre = ((at + 0.5) * width) / STRIPES;
    const band = grey.filter((_, x) => x + 0.5 - centre > -reach && x + 0.5 - centre <= reach);
    return (sum(band) / band.length - 127.5) / 120;
  });
}
