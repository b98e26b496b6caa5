/** The models of one set: the encoder, the heads and the embeddings, each fetched when it is first used. */

import { withoutDots } from "./dots.js";
import { Refused } from "./refusal.js";
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

  /** Run a graph of the set on {name: [type, values, shape]}; name -> {shape, values} of `wanted`, or of all. */
  async ran(url, title, feeds, wanted) {
    const { Tensor } = await this.runtime();
    const session = await this.session(url, title);
    const taken = Object.fromEntries(session.inputNames.map((name) => [name, new Tensor(...feeds[name])]));
    const out = await inTurn(() => session.run(taken, wanted ?? session.outputNames));
    return Object.fromEntries(
      Object.entries(out).map(([name, { dims, data }]) => [name, { shape: dims, values: data }]),
    );
  }

  /** Run a head on one pair of embeddings, a missing one null, at several orders of VIS and of TAC. */
  async run({ url }, { vis, tac }, orders) {
    const { width } = await this.about();
    const row = (one) => ["float32", Float32Array.from(one ?? new Float32Array(width)), [1, width]];
    const stops = orders.length === 1 ? [...orders, ...orders] : orders; // the graph takes two or more
    const both = Float64Array.from([...stops.map(([p]) => p), ...stops.map(([, p]) => p)]);
    return this.ran(url, "the head", { vis: row(vis), tac: row(tac), orders: ["float64", both, [2, stops.length]] });
  }

  /** The outputs `wanted` of a head's stages, for many pairs of embeddings at one order. */
  async stages(head, { vis, tac }, order, wanted) {
    const { width } = await this.about();
    const count = Math.max(2, vis.length); // the graph takes two or more
    const flat = (rows) => {
      const all = new Float32Array(count * width);
      rows.forEach((row, i) => all.set(row, i * width));
      return ["float32", all, [count, width]];
    };
    const orders = ["float64", new Float64Array(count).fill(order), [count]];
    return this.ran(new URL(head.stages, this.folder), "the tree", { vis: flat(vis), tac: flat(tac), orders }, wanted);
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

  /** A picture {pixels, width, height} of another size, as Pillow resizes. */
  async resized({ pixels, width, height }, wide, high) {
    const { resized } = await this.ran(new URL("resize.onnx", this.base), "", {
      picture: ["uint8", pixels, [1, height, width, 3]],
      shape: ["int64", BigInt64Array.of(1n, BigInt(high), BigInt(wide), 3n), [4]],
    });
    return { pixels: resized.values, width: wide, height: high };
  }

  /** The picture within `most` × `most` pixels. */
  within(picture, most) {
    const scale = Math.min(1, most / Math.max(picture.width, picture.height));
    const side = (length) => Math.max(1, Math.round(scale * length));
    return scale === 1 ? picture : this.resized(picture, side(picture.width), side(picture.height));
  }

  /** The embedding of a picture, as `seen` gives it. */
  async encoded(picture) {
    const { encoder } = await this.about();
    if (!encoder) throw new Refused(NOT_HERE, 501);
    if (encoder.kind === "strip") return signalOf(picture);
    const url = new URL(encoder.file, this.base);
    const [{ pixels }] = await Promise.all([this.resized(picture, SIDE, SIDE), this.session(url, "the encoder")]);
    const feeds = { picture: ["uint8", pixels, [1, SIDE, SIDE, 3]] };
    const [{ values }] = Object.values(await this.ran(url, "the encoder", feeds));
    return values;
  }

  /** The embedding of one image of a pair of the set. */
  async row(number, modality) {
    const { part } = await this.about();
    const some = await this.file(`set-${Math.floor(number / part)}.safetensors`);
    return Float32Array.from(rowOf(some[modality], number % part));
  }
}

/** The signal of a picture of 64 upright stripes, -1 to 1: the mean grey of the pixels with a centre in each. */
export function signalOf({ pixels, width, height }) {
  const grey = new Float64Array(width); // means of the columns
  for (let x = 0; x < width; x++)
    for (let y = 0, at = 3 * x; y < height; y++, at += 3 * width)
      grey[x] += ((19595 * pixels[at] + 38470 * pixels[at + 1] + 7471 * pixels[at + 2] + 0x8000) >> 16) / height;
  const reach = Math.max(1, width / 64) / 2;
  return Float32Array.from({ length: 64 }, (_, at) => {
    const centre = ((at + 0.5) * width) / 64;
    const band = grey.filter((_, x) => x + 0.5 - centre > -reach && x + 0.5 - centre <= reach);
    return (band.reduce((a, b) => a + b, 0) / band.length - 127.5) / 120;
  });
}
