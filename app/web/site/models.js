/** The models of one set: the encoder, the heads and the embeddings, each fetched when it is first used. */

import { IMAGES } from "../shared/images.js";
import { keeper } from "../shared/once.js";
import { Refusal } from "../shared/refusal.js";
import { withoutDots } from "./dots.js";
import { inTurn, LOST, runtime } from "./runtime.js";
import { rowOf, tensorOf, tensors } from "./tensors.js";

const NOT_HERE =
  "Pictures for this head's encoder need Python: run `python -m pip install -r requirements.txt`, " +
  "then `python app.py`.";
export class Models {
  once = keeper();

  /** @param {string | URL} base address of the models @param {string} set its folder
   * @param {(step: Step) => void} onStep called while a download is on its way */
  constructor(base, set, onStep = () => {}) {
    this.base = base;
    this.folder = new URL(`${set}/`, base);
    this.onStep = onStep;
  }

  runtime = () => runtime(this.base, this.fetch);

  /** The bytes of a file of the models, which lies there packed; one with a title reports its progress.
   * @param {string | URL} file @param {string} [title] */
  fetch = async (file, title) => {
    const response = await fetch(`${new URL(file, this.folder)}.gz`).catch(() => null);
    if (!response?.ok || !response.body) throw new Refusal(LOST);
    const total = Number(response.headers.get("Content-Length")) || 0;
    let done = 0;
    const tell = (/** @type {number} */ of) => title && this.onStep({ text: title, done, total: of });
    const counted = new TransformStream({
      transform(/** @type {Uint8Array} */ piece, out) {
        done += piece.length;
        tell(total);
        out.enqueue(piece);
      },
    });
    const packed = await new Response(response.body.pipeThrough(counted)).blob();
    tell(done);
    const [a, b] = new Uint8Array(await packed.slice(0, 2).arrayBuffer());
    if (a !== 0x1f || b !== 0x8b) return packed.arrayBuffer(); // the server has unpacked it
    return new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  };

  about = () => this.once("models.json", async () => new Response(await this.fetch("models.json")).json());

  /** @param {string} name */
  file = (name) => this.once(name, async () => tensors(await this.fetch(name), name));

  /** @param {string} file @param {string} title */
  session = (file, title) =>
    this.once(file, async () => {
      const [{ InferenceSession }, bytes] = await Promise.all([this.runtime(), this.fetch(file, title)]);
      return inTurn(() => InferenceSession.create(new Uint8Array(bytes), { executionProviders: ["wasm"] }));
    });

  /** A head of the set, as models.json has it. @param {string | null} [wanted] @returns {Promise<SiteHead>} */
  async head(wanted) {
    const name = wanted ?? "";
    const head = (await this.about()).heads[name];
    if (!head) throw new Refusal(`No head is called '${String(name).slice(0, 40)}' here.`);
    return { ...head, name };
  }

  /** Run a graph on its inputs by name; its outputs by name, of `wanted` or all.
   * @param {string} file @param {Tensors} inputs @param {string} [title] @param {string[]} [wanted]
   * @returns {Promise<Tensors>} */
  async ran(file, inputs, title = "", wanted = undefined) {
    const [{ Tensor }, session] = await Promise.all([this.runtime(), this.session(file, title)]);
    const entries = session.inputNames.map((/** @type {string} */ name) => {
      const { values, shape } = inputs[name];
      return [name, new Tensor(values, shape)];
    });
    const out = await inTurn(() => session.run(Object.fromEntries(entries), wanted ?? session.outputNames));
    return Object.fromEntries(
      Object.entries(out).map(([name, { dims, data }]) => [name, { shape: dims, values: data }]),
    );
  }

  /** What a function of the library returns: arguments and results in the order of app/site/programs.py.
   * @param {string} name @param {(Tensor | Floats | number)[]} given @returns {Promise<Tensor[]>} */
  async rule(name, ...given) {
    const file = `../${name}.onnx`;
    const { inputNames, outputNames } = await this.session(file, "");
    const inputs = given.map((input, i) => [inputNames[i], tensorOf(input)]);
    const out = await this.ran(file, Object.fromEntries(inputs));
    return outputNames.map((/** @type {string} */ output) => out[output]);
  }

  /** Run a head: many pairs of embeddings at one stop of p, or one pair at many. A missing embedding is of zeros; a
   * stop of null is what the head learned. @param {SiteHead} head @param {Rows[]} pairs
   * @param {(number | null)[]} stops
   * @param {string[]} [wanted] */
  async run({ file, orders }, pairs, stops, wanted) {
    const { width } = await this.about();
    const count = Math.max(pairs.length, stops.length);
    const both = new Float64Array(2 * count);
    /** @type {Tensors} */
    const inputs = { orders: { values: both, shape: [2, count] } };
    for (const [k, name] of IMAGES.entries()) {
      const rows = new Float32Array(count * width);
      for (let i = 0; i < count; i++) {
        rows.set(pairs[i % pairs.length][name] ?? [], i * width);
        both[k * count + i] = stops[i % stops.length] ?? orders[name];
      }
      inputs[name] = { values: rows, shape: [count, width] };
    }
    return this.ran(file, inputs, "the head", wanted);
  }

  /** The encoder, which is on its way then. */
  async encoder() {
    const { encoder } = await this.about();
    if (!encoder) throw new Refusal(NOT_HERE, 501);
    const file = `../${encoder.file}`;
    this.session(file, "the encoder");
    return { ...encoder, file };
  }

  /** The embeddings of a picture as photo and as touch: two only where the encoder's training filled dots, and the
   * picture has some. @param {Raster} picture */
  async asEither(picture) {
    const touch = (await this.encoder()).dots === "fill" ? withoutDots(picture) : picture;
    const vis = await this.encoded(picture);
    return { vis, tac: touch === picture ? vis : await this.encoded(touch) };
  }

  /** A picture of another size, as Pillow resizes.
   * @param {Raster} picture @param {number} wide @param {number} high @returns {Promise<Raster>} */
  async resized({ pixels, width, height }, wide, high) {
    const { resized } = await this.ran("../resize.onnx", {
      picture: { values: pixels, shape: [1, height, width, 3] },
      shape: { values: BigInt64Array.of(1n, BigInt(high), BigInt(wide), 3n), shape: [4] },
    });
    return { pixels: resized.values, width: wide, height: high };
  }

  /** The embedding of a picture. @param {Raster} picture @returns {Promise<Float32Array>} */
  async encoded(picture) {
    const { file, side } = await this.encoder();
    const { pixels, width, height } = side ? await this.resized(picture, side, side) : picture;
    const out = await this.ran(file, { picture: { values: pixels, shape: [1, height, width, 3] } }, "the encoder");
    return Object.values(out)[0].values;
  }

  /** The embedding of one image of a pair of the set. @param {number} number @param {Modality} modality */
  async row(number, modality) {
    const { part } = await this.about();
    const some = await this.file(`set-${Math.floor(number / part)}.safetensors`);
    return rowOf(some[modality], number % part);
  }
}
