/** The pictures of a visitor, and what a request names; see app/shared/pair_input.py. Runs in the worker. */

import { imagesOf, READINGS } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { Models } from "./models.js";
import { rounded, roundedRow, rowOf } from "./tensors.js";

/** A name for bytes; two visitors share nothing here, so it only has to tell files apart.
 * @param {Iterable<number>} bytes */
export function nameOf(bytes) {
  let [a, b, length] = [0xdeadbeef, 0x41c6ce57, 0];
  for (const byte of bytes) {
    a = Math.imul(a ^ byte, 2654435761);
    b = Math.imul(b ^ byte, 1597334677);
    length += 1;
  }
  return [a, b, length].map((part) => (part >>> 0).toString(16).padStart(8, "0")).join("");
}

/** The models of a set, and the embeddings of a visitor's pictures: nothing leaves the browser. */
export class Desk extends Models {
  /** Embeddings of pictures, by reference. @type {Map<Ref, Rows>} */
  pictures = new Map();
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
    const row = this.pictures.get(ref)?.[modality];
    if (!row) throw new Refusal("The page no longer has this image; send it again.", 410);
    return row;
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

/** The readings of a head's outputs at one stop; one image alone has its own reading as both.
 * @param {Tensors} out @param {number} stop @param {Rows} pair @returns {Record<string, number[]>} */
export function readingsOf(out, stop, pair) {
  const [alone, other] = imagesOf(pair);
  const names = other ? READINGS : ["fused", alone];
  return Object.fromEntries(names.map((name) => [name, roundedRow(rowOf(out[`p_${other ? name : alone}`], stop))]));
}
