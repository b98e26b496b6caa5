/** The routes of Try a pair whose body is a question: the same reply as the server's. Runs in the worker. */

import { IMAGES, imagesOf, OTHER } from "../shared/images.js";
import { base64 } from "../shared/text.js";
import {
  classroom,
  embedding,
  headFor,
  keepTaught,
  keptProfile,
  lookedAt,
  orderIn,
  pairOf,
  predictOne,
  profileIn,
  readingsOf,
  roundedAll,
  sourceProfile,
  taughtName,
} from "./desk.js";
import { channelsOf, joined, saved } from "./profiles.js";
import { Refused } from "./refusal.js";
import { missing, teach as taughtBy } from "./teaching.js";
import { dot, rounded, unit } from "./tensors.js";

const STOPS = Array.from({ length: 101 }, (_, k) => k / 100);
const COLUMNS = 256; // of the spectrum
const NEAREST = 3;

/** A prediction now and at every stop, with the spectra. */
async function pair(desk, question) {
  const order = orderIn(question.order);
  const rows = await pairOf(desk, question);
  const head = await headFor(desk, question);
  const exact = order ?? head.learned;
  const orders = [...STOPS, exact].map((p) => [p, p]);
  const out = await desk.models.run(head, rows, orders);
  const each = orders.map((_, stop) => readingsOf(head, out, stop, rows));
  const names = ["fused", ...IMAGES].filter((name) => each[0][name]);
  return {
    classes: head.classes,
    orders: STOPS,
    learned: head.learned,
    span: head.span,
    linear: head.linear,
    stops: Object.fromEntries(names.map((name) => [name, each.slice(0, -1).map((one) => rounded(one[name]))])),
    exact: { order: exact, readings: roundedAll(each.at(-1)) },
    spectra: Object.fromEntries(imagesOf(rows).map((name) => [name, spectrum(out[`${name}_size`], STOPS.length)])),
  };
}

/** Moduli (P, D) as a picture of bytes. */
function spectrum({ shape, values }, rows) {
  const width = shape[1];
  const columns = Math.min(width, COLUMNS);
  const edges = Array.from({ length: columns + 1 }, (_, i) => Math.floor((i * width) / columns));
  const joint = new Float64Array(rows * columns);
  for (let row = 0; row < rows; row++)
    for (let column = 0; column < columns; column++)
      for (let i = edges[column]; i < edges[column + 1]; i++)
        joint[row * columns + column] = Math.max(joint[row * columns + column], values[row * width + i]);
  const top = joint.reduce((a, b) => Math.max(a, b), 0) || 1;
  const pixels = Uint8Array.from(joint, (value) => Math.round((value / top) * 255));
  return { rows, columns, width, top, pixels: base64(pixels) };
}

async function attention(desk, question) {
  const rows = await pairOf(desk, question);
  const head = await headFor(desk, question);
  const names = IMAGES.filter((name) => rows[name] && head.tokens[name]);
  if (!names.length) throw new Refused("This head has no MFFA, so there is no attention to show.");
  const out = await desk.models.run(
    head,
    rows,
    STOPS.map((p) => [p, p]),
  );
  const by = (make) => Object.fromEntries(names.map((name) => [name, make(name)]));
  const count = (name) => out[`${name}_attention`].shape.at(-1);
  const found = by((name) => Array.from(out[`${name}_attention`].values, (value) => value - 1 / count(name)));
  const scale =
    Object.values(found)
      .flat()
      .reduce((top, value) => Math.max(top, Math.abs(value)), 0) || 1;
  const coded = (values) => base64(new Uint8Array(Int8Array.from(values, (v) => Math.round((v / scale) * 127)).buffer));
  return {
    tokens: by((n) => head.tokens[n]),
    count: by(count),
    off: by((n) => coded(found[n])),
    scale,
    learned: head.learned,
  };
}

async function many(desk, question) {
  const head = await headFor(desk, question);
  const predicted = async (pair) => {
    const rows = await pairOf(desk, { ...question, ...pair });
    return predictOne(desk, head, rows, { before: await pairOf(desk, pair), question });
  };
  return { classes: head.classes, pairs: await Promise.all(question.pairs.map(predicted)) };
}

/** The training pairs of the set: {pair, row}, of length 1. */
const trained = (desk, name, reader) =>
  desk.models.once(`training ${name} ${reader}`, async () => {
    const { training } = await desk.models.head(reader);
    const rows = training.index.map(async (pair) => ({ pair, row: unit(await desk.models.row(pair, name)) }));
    return Promise.all(rows);
  });

/** The nearest training pairs of the set by cosine, except the pair itself. */
async function nearest(desk, name, row, own, reader) {
  const query = unit(row);
  const found = (await trained(desk, name, reader)).map((one) => ({ pair: one.pair, cosine: dot(query, one.row) }));
  const sorted = found.filter((one) => one.pair !== own).sort((a, b) => b.cosine - a.cosine);
  return sorted.slice(0, NEAREST).map((one) => ({ ...one, cosine: rounded([one.cosine], 4)[0] }));
}

async function familiar(desk, question) {
  const rows = await pairOf(desk, { ...question, profile: "" });
  const looked = await lookedAt(desk, rows, question);
  const images = {};
  for (const name of imagesOf(rows)) {
    const ref = question[name];
    const itself = ref.startsWith("row:") ? Number(ref.slice(4)) : -1;
    const near = await nearest(desk, name, rows[name], itself, question.head);
    images[name] = { nearest: near, ...looked[name] };
    if (ref.startsWith("image:") && !question.profile) {
      const [there] = await nearest(desk, OTHER[name], rows[name], -1, question.head);
      images[name].strays = there.cosine > near[0].cosine;
    }
  }
  return { images, of: (await desk.models.head(question.head)).training.of };
}

/** A profile of a visitor's pictures without labels, or more pictures for one. */
async function profile(desk, question) {
  await sourceProfile(desk);
  const { photos = [], touches = [] } = question;
  const channels = { ...profileIn(desk, question)?.channels };
  for (const [name, refs] of [
    ["vis", photos],
    ["tac", touches],
  ]) {
    if (!refs.length) continue;
    const rows = await Promise.all(refs.map((ref) => embedding(desk, ref, name, {})));
    const found = channelsOf(rows);
    channels[name] = channels[name] ? joined(channels[name], found) : found;
  }
  return keptProfile(desk, { channels });
}

async function saveSensor(desk, question) {
  return saved(profileIn(desk, question), (await desk.models.about()).key);
}

/** What the head says of each lesson before and after teaching. */
async function teach(desk, question) {
  const head = await desk.models.head(question.head);
  const room = await classroom(desk, head, question);
  const lacking = missing(room.lessons);
  if (lacking) throw new Refused(lacking);
  const { report, made } = await taughtBy(room);
  keepTaught(desk, question, made);
  return { ...report, classes: made.classes };
}

async function taughtRoute(desk, question) {
  await headFor(desk, question);
  return { taught: taughtName(question) };
}

export const QUESTIONS = {
  pair,
  many,
  attention,
  familiar,
  profile,
  teach,
  taught: taughtRoute,
  "save/sensor": saveSensor,
};
