/** What a visitor has given to one set, and the pair and head that a question names. Runs in the worker. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { moved, profileFrom } from "./profiles.js";
import { Refused } from "./refusal.js";
import { lessonsIn, teach, withLessons } from "./teaching.js";
import { dot, mean, rounded, rowOf, unit } from "./tensors.js";

const READINGS = ["fused", "vis", "tac", "vis_branch", "tac_branch"];
const UNLIKE = 0.05; // below this quantile a prediction is a guess
const NEIGHBOURS = 10; // nearest images of a hundred or more

/** What this visitor has given to one set: pictures, profiles, lessons. Nothing leaves the browser. */
export class Desk {
  constructor(models) {
    this.models = models;
    this.sent = new Map(); // reference -> its embeddings as {vis, tac}
    this.profiles = new Map();
    this.taught = new Map();
  }
}

/** A name for bytes; two visitors share nothing here, so it only has to tell files apart. */
export function nameOf(bytes) {
  let [a, b] = [0xdeadbeef, 0x41c6ce57];
  for (const byte of bytes) {
    a = Math.imul(a ^ byte, 2654435761);
    b = Math.imul(b ^ byte, 1597334677);
  }
  return [a, b, bytes.length].map((part) => (part >>> 0).toString(16).padStart(8, "0")).join("");
}

/** p of a question; null for the learned one. */
export const orderIn = (value) => (value === null || value === undefined || value === "" ? null : Number(value));

/** The embedding of one reference, moved by the question's profile if it is a visitor's picture. */
export async function embedding(desk, ref, modality, question) {
  const [, kind, name] = /^(\w+):(.*)$/.exec(ref) ?? [];
  if (kind === "row") return desk.models.row(Number(name), modality);
  if (kind === "example") return desk.models.row((await desk.models.about()).rows[name], modality);
  const row = desk.sent.get(ref)?.[modality];
  if (!row) throw new Refused("The page no longer has this image; send it again.", 410);
  return movedBy(desk, question, modality, row);
}

export async function movedBy(desk, question, modality, row) {
  const profile = profileIn(desk, question);
  if (!profile?.channels[modality]) return row;
  const { channels, step } = await sourceProfile(desk, question.head);
  return moved(row, profile.channels[modality], channels[modality], step);
}

export function profileIn(desk, { profile }) {
  if (!profile) return null;
  const found = desk.profiles.get(profile);
  if (!found) throw new Refused("The page no longer has the profile of your sensor; load it again.", 410);
  return found;
}

export async function sourceProfile(desk, head = "") {
  const file = await desk.models.part(head, "profile");
  if (!file) throw new Refused("This head has no profile of its source, so no sensor's profile can be matched to it.");
  return profileFrom(file);
}

/** Both embeddings of a question's pair; null for a missing image. The page sends no question without any. */
export async function pairOf(desk, question) {
  const rows = await Promise.all(
    IMAGES.map((name) => (question[name] ? embedding(desk, question[name], name, question) : null)),
  );
  return { vis: rows[0], tac: rows[1] };
}

/** The head of a question, taught by its lessons. */
export async function headFor(desk, question) {
  const head = await desk.models.head(question.head);
  const lessons = lessonsIn(question);
  if (!lessons.length) return head;
  const key = taughtName(question);
  if (!desk.taught.has(key)) keepTaught(desk, question, (await teach(await classroom(desk, head, question))).made);
  return desk.taught.get(key);
}

/** A taught head is kept with its lessons: what its pictures are compared with. */
export const keepTaught = (desk, question, made) =>
  desk.taught.set(taughtName(question), { ...made, lessons: question.lessons });

export const taughtName = ({ head = "", profile = "", lessons }) =>
  nameOf(new TextEncoder().encode(JSON.stringify([head, profile, lessons])));

/** What teaching needs: lessons as pairs of embeddings, and a way to run the head. */
export async function classroom(desk, head, question) {
  const lessons = await Promise.all(
    lessonsIn(question).map(async (one) => ({ label: one.label, pair: await pairOf(desk, { ...question, ...one }) })),
  );
  return { head, lessons, run: (pair) => desk.models.run(head, pair, [learned(head)]) };
}

export const learned = ({ orders }) => [orders.vis, orders.tac];

/** The readings of a head's outputs at one stop; one image alone has its own reading as both. */
export function readingsOf(head, out, stop, pair) {
  const there = imagesOf(pair);
  const of = (name) => Array.from(rowOf(out[`p_${name}`], stop));
  const names = there.length > 1 ? READINGS : ["fused", ...there];
  const graph = (name) => of(there.length === 1 ? there[0] : name);
  const before = Object.fromEntries(names.map((name) => [name, graph(name)]));
  return head.map ? withLessons(head.map, before, out) : before;
}

export const roundedAll = (readings) =>
  Object.fromEntries(Object.entries(readings).map(([name, row]) => [name, rounded(row)]));

/** Readings at the learned order, and the familiarity of each image. before: the pair before any profile.
 * @param {{before?: any, order?: number | null, question?: any}} more */
export async function predictOne(desk, head, rows, more = {}) {
  const { before = rows, order = null, question = {} } = more;
  const out = await desk.models.run(head, rows, [order === null ? learned(head) : [order, order]]);
  return { readings: roundedAll(readingsOf(head, out, 0, rows)), images: await lookedAt(desk, before, question) };
}

/** What images are compared with, by modality: {rows, quantiles}, of the lessons of a question or the training. */
async function knownTo(desk, question) {
  const lessons = lessonsIn(question);
  const pairs = await Promise.all(lessons.map((one) => pairOf(desk, one))); // before any profile
  const own = IMAGES.map((name) => [name, pairs.flatMap((pair) => (pair[name] ? [unit(pair[name])] : []))]);
  const several = own.filter(([, rows]) => rows.length > 1);
  if (several.length)
    return Object.fromEntries(several.map(([name, rows]) => [name, { rows, quantiles: nearestOf(rows) }]));
  const known = await desk.models.part(question.head, "familiarity");
  if (!known) return {};
  const there = IMAGES.filter((name) => known[name]);
  const rowsOf = (all) => Array.from({ length: all.shape[0] }, (_, i) => unit(rowOf(all, i)));
  return Object.fromEntries(
    there.map((name) => [name, { rows: rowsOf(known[name]), quantiles: known[`${name}_quantiles`].values }]),
  );
}

/** The largest cosines, ascending: N / 10 of N, at least 1 and at most NEIGHBOURS. */
function nearestCosines(cosines) {
  const count = Math.min(NEIGHBOURS, Math.max(1, Math.floor(cosines.length / 10)));
  return Float64Array.from(cosines).sort().subarray(-count);
}

/** The same of each row among the others, ascending. */
const nearestOf = (rows) =>
  rows
    .map((row, i) => mean(nearestCosines(rows.map((other, j) => (i === j ? -1 : dot(row, other))))))
    .sort((a, b) => a - b);

/** Cosine to the nearest known image of each modality, its place among the known images, and words. */
export async function lookedAt(desk, rows, question = {}) {
  const known = await knownTo(desk, question);
  const found = {};
  for (const name of IMAGES.filter((one) => rows[one] && known[one])) {
    const query = unit(rows[name]);
    const near = nearestCosines(known[name].rows.map((row) => dot(query, row)));
    const cosine = near[near.length - 1];
    const quantile = quantileOf(mean(near), known[name].quantiles);
    const guess = quantile < UNLIKE;
    const words = guess ? "unlike the training images" : "familiar";
    found[name] = { cosine: rounded([cosine], 4)[0], quantile: rounded([quantile], 3)[0], words, guess };
  }
  return found;
}

/** The place of a value among ascending quantiles, 0 to 1. */
function quantileOf(value, quantiles) {
  const last = quantiles.length - 1;
  const above = quantiles.findIndex((one) => one > value);
  const upper = Math.min(last, Math.max(1, above < 0 ? last : above));
  const [low, high] = [quantiles[upper - 1], quantiles[upper]];
  const inside = Math.min(1, Math.max(0, (value - low) / Math.max(1e-12, high - low)));
  return (upper - 1 + inside) / last;
}

/** Keep a profile; its name, and the pictures of each image. */
export function keptProfile(desk, found) {
  const counts = Object.fromEntries(Object.entries(found.channels).map(([name, one]) => [name, one.count]));
  const bytes = Object.values(found.channels).flatMap((one) => [one.mean, one.variance]);
  const name = nameOf(bytes.flatMap((values) => [...new Uint8Array(values.buffer)]));
  desk.profiles.set(name, found);
  return { profile: name, counts };
}
