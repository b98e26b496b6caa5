/** The models of one set: the encoder, the heads and the embeddings, each fetched when it is first used. */

import { withoutDots } from "./dots.js";
import { Refused } from "./refusal.js";
import { FILTERS, resized } from "./resize.js";
import { inTurn, LOST, runtime } from "./runtime.js";
import { rowOf, tensors } from "./tensors.js";

const SIDE = 224; // pixels that the encoder sees
const NOT_HERE =
  "Pictures for this head's encoder need Python: run `python -m pip install -r requirements.txt`, then `python app.py`.";

/** The bytes of a file of the models, which lies there packed; `told` receives the bytes on their way. */
async function fetched(url, told = (_) => {}) {
  const response = await fetch(`${url}.gz`).catch(() => null);
  if (!response?.ok) throw new Refused(LOST);
  const total = Number(response.headers.get("Content-Length")) || 0;
  const parts = [];
  let done = 0;
  const reader = /** @type {ReadableStream<Uint8Array<ArrayBuffer>>} */ (response.body).getReader();
  for (let next = await reader.read(); !next.done; next = await reader.read()) {
    parts.push(next.value);
    told({ done: (done += next.value.length), total });
  }
  told({ done, total: done });
  const packed = new Blob(parts);
  const [a, b] = new Uint8Array(await packed.slice(0, 2).arrayBuffer());
  if (a !== 0x1f || b !== 0x8b) return packed.arrayBuffer(); // the server has unpacked it
  return new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

/** Remember what is on its way; a failure is tried again. */
function once(kept, key, make) {
  if (!kept.has(key)) {
    const made = make();
    kept.set(key, made);
    made.catch(() => kept.delete(key));
  }
  return kept.get(key);
}

export class Models {
  /** base: address of the models; set: its folder; told: receives {text, done, total} of a download. */
  constructor(base, set, told = (_) => {}) {
    this.base = base;
    this.folder = new URL(`${set}/`, base);
    this.told = told;
    this.kept = new Map();
  }

  once = (key, make) => once(this.kept, key, make);

  runtime = () => runtime(this.base, (url, title) => this.fetch(url, title));

  /** The bytes of a file beside the models; the page is told of one with a title. */
  fetch = (url, title = "") => fetched(url, (now) => title && this.told({ text: title, ...now }));

  about = () =>
    this.once("models.json", async () =>
      JSON.parse(new TextDecoder().decode(await this.fetch(new URL("models.json", this.folder)))),
    );

  file = (name) => this.once(name, async () => tensors(await this.fetch(new URL(name, this.folder)), name));

  session = (url, title) =>
    this.once(`${url}`, async () => {
      const bytes = this.fetch(url, title);
      bytes.catch(() => {}); // reported below
      const { InferenceSession } = await this.runtime();
      const model = new Uint8Array(await bytes);
      return inTurn(() => InferenceSession.create(model, { executionProviders: ["wasm"] }));
    });

  /** A head of the set: what models.json has of it, and its graph. */
  async head(name = "") {
    const { heads } = await this.about();
    const found = heads[name ?? ""];
    if (!found) throw new Refused(`No head is called '${String(name).slice(0, 40)}' here.`);
    return { ...found, name: name ?? "", url: new URL(found.file, this.folder) };
  }

  /** The tensors of a part of a head's folder, "familiarity" or "profile"; null without it. */
  async part(name, part) {
    const { parts } = await this.head(name);
    return parts[part] ? this.file(parts[part]) : null;
  }

  /** Run a head on one pair of embeddings, a missing one null, at several orders of VIS and of TAC. */
  async run(head, { vis, tac }, orders) {
    const { Tensor } = await this.runtime();
    const session = await this.session(head.url, "the head");
    const { width } = await this.about();
    const row = (one) => new Tensor("float32", Float32Array.from(one ?? new Float32Array(width)), [1, width]);
    const stops = orders.length === 1 ? [...orders, ...orders] : orders; // the graph takes two or more
    const both = Float64Array.from([...stops.map(([p]) => p), ...stops.map(([, p]) => p)]);
    const { directions } = head;
    const flat = Float32Array.from(directions.flat());
    const feeds = {
      vis: row(vis),
      tac: row(tac),
      orders: new Tensor("float64", both, [2, stops.length]),
      directions: new Tensor("float32", flat, [directions.length, directions[0].length]),
    };
    const given = Object.entries(feeds).filter(([name]) => session.inputNames.includes(name));
    const found = await inTurn(() => session.run(Object.fromEntries(given)));
    return Object.fromEntries(
      Object.entries(found).map(([name, { dims, data }]) => [name, { shape: dims, values: data }]),
    );
  }

  /** The outputs `wanted` of a head's stages, for many pairs of embeddings at one order. */
  async stages(head, { vis, tac }, order, wanted) {
    const { Tensor } = await this.runtime();
    const session = await this.session(new URL(head.stages, this.folder), "the tree");
    const { width } = await this.about();
    const count = Math.max(2, vis.length); // the graph takes two or more
    const flat = (rows) => {
      const all = new Float32Array(count * width);
      rows.forEach((row, i) => all.set(row, i * width));
      return new Tensor("float32", all, [count, width]);
    };
    const orders = new Tensor("float64", new Float64Array(count).fill(order), [count]);
    const found = await inTurn(() => session.run({ vis: flat(vis), tac: flat(tac), orders }, wanted));
    return Object.fromEntries(wanted.map((name) => [name, { shape: found[name].dims, values: found[name].data }]));
  }

  /** The picture as the encoder gets it as "vis" or "tac": the dots of a gel are filled if they were in training. */
  async seen(picture, modality) {
    const { encoder } = await this.about();
    return modality === "tac" && encoder?.dots === "fill" ? withoutDots(picture) : picture;
  }

  /** The embeddings of a picture as photo and as touch, {vis, tac}: two only where dots were filled. */
  async asEither(picture) {
    const touch = await this.seen(picture, "tac");
    const vis = await this.encoded(picture);
    return { vis, tac: touch === picture ? vis : await this.encoded(touch) };
  }

  /** The embedding of a picture {pixels, width, height}, as `seen` gives it. */
  async encoded(picture) {
    const { encoder } = await this.about();
    if (!encoder) throw new Refused(NOT_HERE, 501);
    if (encoder.kind === "strip") return signalOf(picture);
    const { Tensor } = await this.runtime();
    const session = await this.session(new URL(encoder.file, this.base), "the encoder");
    const { pixels } = resized(picture, SIDE, SIDE);
    const plane = SIDE * SIDE;
    const input = new Float32Array(3 * plane);
    for (let channel = 0; channel < 3; channel++) {
      const [mean, scale] = [encoder.mean[channel], encoder.std[channel]];
      for (let i = 0; i < plane; i++) input[channel * plane + i] = (pixels[3 * i + channel] / 255 - mean) / scale;
    }
    const images = new Tensor("float32", input, [1, 3, SIDE, SIDE]);
    const found = await inTurn(() => session.run({ images }));
    return Float32Array.from(/** @type {any} */ (Object.values(found)[0]).data);
  }

  /** The embedding of one image of a pair of the set. */
  async row(number, modality) {
    const { pairs, part } = await this.about();
    if (!(number >= 0 && number < pairs))
      throw new Refused(`No pair has the number '${number}'; there are 0 to ${pairs - 1}.`);
    const some = await this.file(`set-${Math.floor(number / part)}.safetensors`);
    return Float32Array.from(rowOf(some[modality], number % part));
  }
}

/** The signal of a picture of 64 upright stripes, -1 to 1. */
export function signalOf({ pixels, width, height }) {
  const grey = new Float64Array(width); // means of the columns
  for (let y = 0, at = 0; y < height; y++)
    for (let x = 0; x < width; x++, at += 3)
      grey[x] += (19595 * pixels[at] + 38470 * pixels[at + 1] + 7471 * pixels[at + 2] + 0x8000) >> 16;
  const scale = width / 64;
  const stretch = Math.max(1, scale);
  return Float32Array.from({ length: 64 }, (_, at) => {
    const centre = (at + 0.5) * scale;
    const first = Math.max(0, Math.trunc(centre - 0.5 * stretch + 0.5));
    const end = Math.min(width, Math.trunc(centre + 0.5 * stretch + 0.5));
    const shares = Array.from({ length: end - first }, (_, i) => FILTERS.box[0]((i + first - centre + 0.5) / stretch));
    const sum = shares.reduce((a, b) => a + b, 0);
    const band = shares.reduce((total, share, i) => total + (share / sum) * (grey[first + i] / height), 0);
    return (band - 127.5) / 120;
  });
}
