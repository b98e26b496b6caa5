/** The pictures of a visitor, and what a request names; see app/shared/pair_input.py. Runs in the worker. */

import { imagesOf, READINGS, withImages } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { base64, bytesOf } from "../shared/text.js";
import { decoded } from "./decode.js";
import { Models } from "./models.js";
import { rounded, roundedRow, rowOf } from "./tensors.js";

/** The models of a set, and the embeddings of a visitor's pictures: nothing leaves the browser. */
export class Desk extends Models {
  /** A stage of the whole set, as far as it is computed. @type {{ key: string } & Record<Modality, Floats[]>} */
  walk = { key: "", vis: [], tac: [] };

  /** The pair, the order and the head of a request. @param {any} question @returns {Promise<Resolved>} */
  async resolved(question) {
    const { order, head } = question;
    /** @type {Rows} */
    const pair = {};
    for (const name of imagesOf(question)) pair[name] = await this.embedding(question[name], name);
    return { pair, order: (order ?? "") === "" ? null : Number(order), head: await this.head(head) };
  }

  /** The embedding of one reference. @param {Ref} ref @param {Modality} modality @returns {Promise<Floats>} */
  async embedding(ref, modality) {
    if (!ref.startsWith("image:")) return this.row(await this.rowOf(ref), modality);
    const [, encoder, text] = ref.split(":");
    const { key, width } = await this.about();
    if (encoder !== key) throw new Refusal("Another encoder has read this image; choose its file again.", 410);
    const rows = new Float32Array(bytesOf(text).buffer);
    return modality === "tac" ? rows.subarray(rows.length - width) : rows.subarray(0, width);
  }

  /** What a picture holds, in its place from then on, and its size and a small copy; or why it cannot be read.
   * @param {Uint8Array} content @param {string} name */
  async taken(content, name) {
    const { rules, key } = await this.about();
    try {
      const { raster, ...about } = await decoded(content, name.slice(0, 120) || "the image", rules);
      const { vis, tac } = await this.asEither(raster);
      const rows = (vis === tac ? [vis] : [vis, tac]).map((row) => new Uint8Array(Float32Array.from(row).buffer));
      const numbers = new Uint8Array(rows.flatMap((row) => [...row]));
      return { ...about, ref: `image:${key}:${base64(numbers)}` };
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      return { problem: error.message };
    }
  }

  /** Do some work on a question whose "file:0", … are the pictures that came with it; see app/pair/pictures.py.
   * @param {any} question @param {Uint8Array[]} files @param {(question: any) => any} work */
  async withPictures({ names = [], ...question }, files, work) {
    if (!files.length) return work(question);
    /** @type {Record<string, any>[]} */
    const pictures = [];
    for (const [at, content] of files.entries()) pictures.push(await this.taken(content, names[at] ?? ""));
    const problem = pictures.map((picture) => picture.problem).find(Boolean);
    if (problem) return { problem, pictures };
    const read = (/** @type {any} */ ref) => pictures[Number(/^file:(\d+)$/.exec(ref)?.[1] ?? -1)]?.ref ?? ref;
    return { ...(await work(withImages(question, read))), pictures };
  }

  /** The row of the set that an image is of; undefined if it is of none. @param {Ref} ref @returns {Promise<any>} */
  async rowOf(ref) {
    const [, kind, name] = /^(\w+):(.*)$/.exec(ref) ?? [];
    return kind === "row" ? Number(name) : kind === "example" ? (await this.about()).rows[name] : undefined;
  }

  /** Cosine to the nearest training image of each modality, its quantile among the training images, and words.
   * @param {Resolved} found */
  async lookedAt({ pair, head }) {
    const { unlike, words } = (await this.about()).rules.familiar;
    const known = head.familiarity ? await this.file(head.familiarity) : {};
    /** @type {Partial<Record<Modality, Familiarity>>} */
    const looks = {};
    for (const name of imagesOf(pair).filter((image) => known[image])) {
      const given = [/** @type {Floats} */ (pair[name]), known[name], known[`${name}_quantiles`]];
      const [cosine, place] = (await this.rule("look", ...given)).map(({ values }) => values[0]);
      const quantile = rounded(place, 3);
      const guess = quantile < unlike;
      looks[name] = { cosine: rounded(cosine, 4), quantile, words: words[Number(!guess)], guess };
    }
    return looks;
  }
}

/** Return the readings of a head's outputs at one stop; one image alone has its own reading as both.
 * @param {Tensors} out @param {number} stop @param {Rows} pair @returns {Record<string, number[]>} */
export function readingsOf(out, stop, pair) {
  const [alone, other] = imagesOf(pair);
  const names = other ? READINGS : ["fused", alone];
  return Object.fromEntries(names.map((name) => [name, roundedRow(rowOf(out[`p_${other ? name : alone}`], stop))]));
}
