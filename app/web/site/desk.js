/** What a visitor has given to one set, and what a question names; see app/pair_input.py. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { Models } from "./models.js";
import { profileFrom } from "./profiles.js";
import { PAIR } from "./rules.js";
import { lessonsIn, teach } from "./teaching.js";
import { rounded, roundedRow, rowOf, stacked } from "./tensors.js";

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

/** The models of a set, and what this visitor gave: nothing leaves the browser. */
export class Desk extends Models {
  /** Embeddings of pictures, profiles and taught heads, by the names that the page has. @type {Map<string, any>} */
  given = new Map();
  /** A stage of the whole set, as far as it is computed. @type {{ key: string } & Record<Modality, Floats[]>} */
  walk = { key: "", vis: [], tac: [] };

  /** What the page names; it sends again what is lost. @param {string} name @param {string} what */
  keptAs(name, what) {
    const value = this.given.get(name);
    if (!value) throw new Refusal(`The page no longer has ${what}`, 410);
    return value;
  }

  /** What a question names. @param {any} question @param {Rows} rows of pictures that came with it
   * @returns {Promise<Asked>} */
  async asked(question, rows = {}) {
    const order = question.order ?? "";
    const head = await this.reader(question);
    return { ...(await this.pairOf(question, rows)), order: order === "" ? null : Number(order), head };
  }

  /** The embeddings of a question's pair: `before` as they come, `pair` with own pictures moved by its profile.
   * @param {any} question @param {Rows} rows */
  async pairOf(question, rows = {}) {
    const profile = this.profileIn(question);
    const source = profile && (await this.sourceProfile(question.head));
    const [before, pair] = [/** @type {Rows} */ ({}), /** @type {Rows} */ ({})];
    for (const name of IMAGES) {
      const ref = question[name];
      const row = rows[name] ?? (ref ? await this.embedding(ref, name) : null);
      const [target, from] = [profile?.channels[name], source?.channels[name]];
      const own = row && (rows[name] || ref.startsWith("image:"));
      before[name] = row;
      pair[name] = own && target && from ? await this.moved(row, target, from, source?.step) : row;
    }
    return { before, pair };
  }

  /** A row of a new sensor as the source of a head has it. @param {Floats} row @param {Channels} target
   * @param {Channels} from of the source @param {number} [step] share of the way @returns {Promise<Floats>} */
  async moved(row, target, from, step = 1) {
    const [moved] = await this.rule("move", row, ...statistics(target), ...statistics(from), step);
    return moved.values;
  }

  /** The statistics of a row together with those of others. @param {Floats} row @param {Channels} [others] */
  async joined(row, others) {
    const single = { mean: row, variance: new Float32Array(row.length), count: 1 };
    if (!others) return single;
    const [mean, variance, count] = await this.rule("join", ...statistics(others), ...statistics(single));
    return { mean: mean.values, variance: variance.values, count: count.values[0] };
  }

  /** The embedding of one reference. @param {Ref} ref @param {Modality} modality @returns {Promise<Floats>} */
  async embedding(ref, modality) {
    if (ref.startsWith("image:")) return this.keptAs(ref, "this image; send it again.")[modality];
    return this.row(await this.rowOf(ref), modality);
  }

  /** The row of the set that an image is of; undefined if it is of none. @param {Ref} ref @returns {Promise<any>} */
  async rowOf(ref) {
    const [, kind, name] = /^(\w+):(.*)$/.exec(ref) ?? [];
    return kind === "row" ? Number(name) : kind === "example" ? (await this.about()).rows[name] : undefined;
  }

  /** @param {{ profile?: string }} question @returns {SensorProfile | null} */
  profileIn({ profile }) {
    return profile ? this.keptAs(profile, "the profile of your sensor; load it again.") : null;
  }

  async sourceProfile(head = "") {
    const file = await this.part(head, "profile");
    if (!file)
      throw new Refusal("This head has no profile of its source, so no sensor's profile can be matched to it.");
    return profileFrom(file);
  }

  /** The head of a question, taught by its lessons. @param {any} question @returns {Promise<SiteHead>} */
  async reader(question) {
    if (question.taught) return this.keptAs(question.taught, "the taught head; press Teach again.");
    return question.lessons?.length ? (await this.learned(question)).made : this.head(question.head);
  }

  /** What the lessons of a question teach its head, what is said of each, and the name of the taught head.
   * @param {any} question */
  async learned(question) {
    const { head = "", profile = "", lessons } = question;
    const name = nameOf(new TextEncoder().encode(JSON.stringify([head, profile, lessons])));
    return this.once(name, async () => {
      const pairs = [];
      for (const { label, vis, tac } of lessonsIn({ lessons }))
        pairs.push({ label, ...(await this.pairOf({ ...question, vis, tac })) });
      const { made, report } = await teach(this, await this.head(head), pairs);
      /** @type {KnownImages} */
      const known = {};
      for (const image of IMAGES) {
        const rows = pairs.flatMap(({ before }) => before[image] ?? []);
        if (rows.length > 1) known[image] = [stacked(rows), ...(await this.rule("among", stacked(rows)))];
      }
      const taught = { ...made, ...(imagesOf(known).length && { known }) };
      this.given.set(name, taught);
      return { made: taught, report, name };
    });
  }

  /** What the images of a head are compared with. @param {SiteHead} head @returns {Promise<KnownImages>} */
  async known({ name, known }) {
    if (known) return known;
    return this.once(`known ${name}`, async () => {
      const file = (await this.part(name, "familiarity")) ?? {};
      const images = IMAGES.filter((image) => file[image]);
      return Object.fromEntries(images.map((image) => [image, [file[image], file[`${image}_quantiles`]]]));
    });
  }

  /** Cosine to the nearest known image of each modality, its place among the known images, and words.
   * @param {Asked} asked */
  async lookedAt({ before, head }) {
    const known = await this.known(head);
    /** @type {Partial<Record<Modality, Familiarity>>} */
    const looks = {};
    for (const name of imagesOf(known)) {
      const [row, others] = [before[name], /** @type {Tensor[]} */ (known[name])];
      if (!row) continue;
      const [cosine, place] = (await this.rule("look", row, ...others)).map(({ values }) => values[0]);
      const quantile = rounded(place, 3);
      const guess = quantile < PAIR.UNLIKE;
      looks[name] = { cosine: rounded(cosine, 4), quantile, words: PAIR.WORDS[Number(!guess)], guess };
    }
    return looks;
  }

  /** The readings of a pair at its p. @param {Asked} asked */
  async readings({ head, pair, order }) {
    return readingsOf(await this.run(head, [pair], [order]), 0, pair);
  }

  /** Readings, and the familiarity of each image. @param {Asked} asked */
  async predicted(asked) {
    return { readings: roundedAll(await this.readings(asked)), images: await this.lookedAt(asked) };
  }

  /** Keep a profile; its name, and the pictures of each image. @param {SensorProfile} profile */
  keepProfile(profile) {
    const parts = Object.entries(profile.channels);
    const values = parts.flatMap(([, { mean, variance }]) => [...mean, ...variance]);
    const name = nameOf(new Uint8Array(Float32Array.from(values).buffer));
    this.given.set(name, profile);
    return { profile: name, counts: Object.fromEntries(parts.map(([image, { count }]) => [image, count])) };
  }
}

/** @param {Channels} of @returns {[Floats, Floats, number]} */
const statistics = ({ mean, variance, count }) => [mean, variance, count];

/** The readings of a head's outputs at one stop; one image alone has its own reading as both.
 * @param {Tensors} out @param {number} stop @param {Rows} pair @returns {Record<string, number[]>} */
export function readingsOf(out, stop, pair) {
  const [alone, other] = imagesOf(pair);
  const names = other ? PAIR.READINGS : ["fused", alone];
  return Object.fromEntries(names.map((name) => [name, [...rowOf(out[`p_${other ? name : alone}`], stop)]]));
}

/** @param {Record<string, number[]>} readings */
export const roundedAll = (readings) =>
  Object.fromEntries(Object.entries(readings).map(([name, row]) => [name, roundedRow(row)]));
