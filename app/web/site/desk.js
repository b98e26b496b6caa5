/** What a visitor has given to one set, and what a question names; see app/pair_input.py. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Models } from "./models.js";
import { moved, profileFrom } from "./profiles.js";
import { Refused } from "./refusal.js";
import { PAIR } from "./rules.js";
import { lessonsIn, teach, withLessons } from "./teaching.js";
import { dot, mean, rounded, roundedRow, rowOf, unit } from "./tensors.js";

const READINGS = ["fused", "vis", "tac", "vis_branch", "tac_branch"];

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

/** The value kept under a name; the page sends again what is lost.
 * @template T @param {Map<string, T>} kept @param {string} name @param {string} sentence */
function keptIn(kept, name, sentence) {
  const value = kept.get(name);
  if (!value) throw new Refused(`The page no longer has ${sentence}`, 410);
  return value;
}

/** The models of a set, and what this visitor gave: nothing leaves the browser. */
export class Desk extends Models {
  /** @type {Map<string, Rows>} */ sent = new Map(); // reference -> its embeddings
  /** @type {Map<string, SensorProfile>} */ profiles = new Map();
  /** @type {Map<string, SiteHead>} */ taught = new Map();
  /** @type {Map<string, { all: Floats[], done: number }>} */ features = new Map(); // of the set, by stage and order

  /** What a question names. @param {any} question @param {Rows} rows of pictures that came with it
   * @returns {Promise<Asked>} */
  async asked(question, rows = {}) {
    const before = await this.pairOf(question, rows);
    const pair = await this.moved(question, before, rows);
    const { order } = question;
    const p = order === null || order === undefined || order === "" ? null : Number(order);
    return { before, pair, order: p, head: await this.reader(question) };
  }

  /** Both embeddings of a question's pair, before any profile. @param {any} question @param {Rows} rows
   * @returns {Promise<Rows>} */
  async pairOf(question, rows = {}) {
    const each = IMAGES.map(
      async (name) => rows[name] ?? (question[name] ? this.embedding(question[name], name) : null),
    );
    const [vis, tac] = await Promise.all(each);
    return { vis, tac };
  }

  /** The embedding of one reference. @param {Ref} ref @param {Modality} modality @returns {Promise<Floats>} */
  async embedding(ref, modality) {
    const [, kind, name] = /^(\w+):(.*)$/.exec(ref) ?? [];
    if (kind === "row") return this.row(Number(name), modality);
    if (kind === "example") return this.row((await this.about()).rows[name], modality);
    return /** @type {Floats} */ (keptIn(this.sent, ref, "this image; send it again.")[modality]);
  }

  /** A pair whose own pictures a question's profile moves. @param {any} question @param {Rows} pair @param {Rows} rows
   * @returns {Promise<Rows>} */
  async moved(question, pair, rows) {
    const profile = this.profileIn(question);
    if (!profile) return pair;
    const { channels, step } = await this.sourceProfile(question.head);
    const each = IMAGES.map((name) => {
      const [row, target, source] = [pair[name], profile.channels[name], channels[name]];
      const own = rows[name] || question[name]?.startsWith("image:");
      return [name, row && own && target && source ? moved(row, target, source, step) : row];
    });
    return Object.fromEntries(each);
  }

  /** @param {{ profile?: string }} question */
  profileIn({ profile }) {
    return profile ? keptIn(this.profiles, profile, "the profile of your sensor; load it again.") : null;
  }

  async sourceProfile(head = "") {
    const file = await this.part(head, "profile");
    if (!file)
      throw new Refused("This head has no profile of its source, so no sensor's profile can be matched to it.");
    return profileFrom(file);
  }

  /** The head of a question, taught by its lessons. @param {any} question */
  async reader(question) {
    if (question.taught) return keptIn(this.taught, question.taught, "the taught head; press Teach again.");
    if (!lessonsIn(question).length) return this.head(question.head);
    const name = taughtName(question);
    return this.taught.get(name) ?? (await this.learned(question)).made;
  }

  /** What the lessons of a question teach its head, and what is said of each; the taught head is kept.
   * @param {any} question */
  async learned(question) {
    const head = await this.head(question.head);
    const lessons = [];
    for (const { label, ...pair } of lessonsIn(question)) {
      const before = await this.pairOf(pair);
      const after = await this.moved({ ...question, vis: pair.vis, tac: pair.tac }, before, {});
      lessons.push({ label, before, pair: after });
    }
    const run = (/** @type {Rows} */ pair) => this.run(head, pair, [learnedOrders(head)]);
    const { made, report } = await teach({ head, lessons, run });
    /** @type {KnownImages} */
    const known = {};
    for (const name of IMAGES) {
      const rows = lessons.flatMap(({ before }) => (before[name] ? [unit(before[name])] : []));
      if (rows.length > 1) known[name] = { rows, quantiles: nearestOf(rows) };
    }
    const taught = { ...made, ...(imagesOf(known).length && { known }) };
    this.taught.set(taughtName(question), taught);
    return { made: taught, report };
  }

  /** What the images of a head are compared with. @param {SiteHead} head @returns {Promise<KnownImages>} */
  async known({ name, known }) {
    if (known) return known;
    return this.once(`known ${name}`, async () => {
      const file = (await this.part(name, "familiarity")) ?? {};
      const images = IMAGES.filter((image) => file[image]).map((image) => {
        const rows = Array.from({ length: file[image].shape[0] }, (_, i) => unit(rowOf(file[image], i)));
        return [image, { rows, quantiles: file[`${image}_quantiles`].values }];
      });
      return Object.fromEntries(images);
    });
  }

  /** Cosine to the nearest known image of each modality, its place among the known images, and words.
   * @param {Asked} asked */
  async lookedAt({ before, head }) {
    const known = await this.known(head);
    /** @type {Partial<Record<Modality, Familiarity>>} */
    const looks = {};
    for (const name of IMAGES) {
      const [row, others] = [before[name], known[name]];
      if (!row || !others) continue;
      const query = unit(row);
      const near = nearestCosines(others.rows.map((other) => dot(query, other)));
      const quantile = quantileOf(mean([...near]), others.quantiles);
      const guess = quantile < PAIR.UNLIKE;
      const words = guess ? "unlike the training images" : "familiar";
      looks[name] = { cosine: rounded(near[near.length - 1], 4), quantile: rounded(quantile, 3), words, guess };
    }
    return looks;
  }

  /** The readings of a pair at its p. @param {Asked} asked */
  async readings({ head, pair, order }) {
    const out = await this.run(head, pair, [order === null ? learnedOrders(head) : [order, order]]);
    return readingsOf(head, out, 0, pair);
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
    this.profiles.set(name, profile);
    return { profile: name, counts: Object.fromEntries(parts.map(([image, { count }]) => [image, count])) };
  }
}

/** @param {any} question */
export const taughtName = ({ head = "", profile = "", lessons }) =>
  nameOf(new TextEncoder().encode(JSON.stringify([head, profile, lessons])));

/** @param {SiteHead} head @returns {[number, number]} */
const learnedOrders = ({ orders }) => [orders.vis, orders.tac];

/** The readings of a head's outputs at one stop; one image alone has its own reading as both.
 * @param {SiteHead} head @param {Tensors} out @param {number} stop @param {Rows} pair @returns {Record<string, number[]>} */
export function readingsOf(head, out, stop, pair) {
  const there = imagesOf(pair);
  const names = there.length > 1 ? READINGS : ["fused", ...there];
  const row = (/** @type {string} */ name) => [...rowOf(out[`p_${there.length > 1 ? name : there[0]}`], stop)];
  const before = Object.fromEntries(names.map((name) => [name, row(name)]));
  return head.map ? withLessons(head.map, before, out) : before;
}

/** @param {Record<string, number[]>} readings */
export const roundedAll = (readings) =>
  Object.fromEntries(Object.entries(readings).map(([name, row]) => [name, roundedRow(row)]));

/** The largest cosines, ascending: N / 10 of N, at least 1 and at most KNOWN. @param {number[]} cosines */
function nearestCosines(cosines) {
  const count = Math.min(PAIR.KNOWN, Math.max(1, Math.floor(cosines.length / 10)));
  return Float64Array.from(cosines).sort().subarray(-count);
}

/** Their mean for each row among the others, ascending. @param {Floats[]} rows */
const nearestOf = (rows) =>
  rows
    .map((row, i) => mean([...nearestCosines(rows.map((other, j) => (i === j ? -1 : dot(row, other))))]))
    .sort((a, b) => a - b);

/** The place of a value among ascending quantiles, 0 to 1. @param {number} value @param {ArrayLike<number>} quantiles */
function quantileOf(value, quantiles) {
  const last = quantiles.length - 1;
  let upper = 1;
  while (upper < last && quantiles[upper] <= value) upper += 1;
  const [low, high] = [quantiles[upper - 1], quantiles[upper]];
  return (upper - 1 + Math.min(1, Math.max(0, (value - low) / Math.max(1e-12, high - low)))) / last;
}
