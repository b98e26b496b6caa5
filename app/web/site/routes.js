/** The routes of Try a pair whose body is a question: the same reply as the server's. Runs in the worker. */

import { IMAGES, imagesOf, OTHER } from "../shared/images.js";
import { base64 } from "../shared/text.js";
import { readingsOf, roundedAll, taughtName } from "./desk.js";
import { channelsOf, joined, saved } from "./profiles.js";
import { Refused } from "./refusal.js";
import { PAIR } from "./rules.js";
import { lessonsIn, missing } from "./teaching.js";
import { dot, rounded, roundedRow, unit } from "./tensors.js";

const STOPS = Array.from({ length: PAIR.STOPS }, (_, k) => k / (PAIR.STOPS - 1));
const named = Object.fromEntries;

/** Moduli (P, D) as a picture of bytes, of neighbours the largest. @param {Tensor} moduli @param {number} rows */
function spectrum({ shape: [, width], values }, rows) {
  const columns = Math.min(width, PAIR.COLUMNS);
  const joint = new Float64Array(rows * columns);
  for (let at = 0; at < rows * width; at++) {
    const column = Math.ceil((((at % width) + 1) * columns) / width) - 1;
    const to = Math.floor(at / width) * columns + column;
    joint[to] = Math.max(joint[to], values[at]);
  }
  const top = joint.reduce((a, b) => Math.max(a, b)) || 1;
  return { rows, columns, width, top, pixels: base64(Uint8Array.from(joint, (v) => Math.round((v / top) * 255))) };
}

/** The nearest training pairs of the set by cosine, except the pair itself.
 * @param {import("./desk.js").Desk} desk @param {SiteHead} head @param {Modality} name @param {Floats} row
 * @param {number} own */
async function nearest(desk, head, name, row, own) {
  const trained = await desk.once(`training ${name} ${head.name}`, () =>
    Promise.all(head.training.index.map(async (pair) => ({ pair, row: unit(await desk.row(pair, name)) }))),
  );
  const query = unit(row);
  const near = trained
    .map((one) => ({ pair: one.pair, cosine: dot(query, one.row) }))
    .filter(({ pair }) => pair !== own);
  const sorted = near.sort((a, b) => b.cosine - a.cosine).slice(0, PAIR.NEAREST);
  return sorted.map(({ pair, cosine }) => ({ pair, cosine: rounded(cosine, 4) }));
}

/** @type {Record<string, Route>} */
export const QUESTIONS = {
  /** A prediction now and at every stop, with the spectra. */
  async pair(desk, question) {
    const { pair, order, head } = await desk.asked(question);
    const exact = order ?? head.learned;
    /** @type {[number, number][]} */
    const orders = [...STOPS, exact].map((p) => [p, p]);
    const out = await desk.run(head, pair, orders);
    const each = orders.map((_, stop) => readingsOf(head, out, stop, pair));
    const last = each[STOPS.length];
    const shown = ["fused", ...IMAGES].filter((name) => last[name]);
    return {
      classes: head.classes,
      orders: STOPS,
      learned: head.learned,
      span: head.span,
      linear: head.linear,
      stops: named(shown.map((name) => [name, each.slice(0, -1).map((one) => roundedRow(one[name]))])),
      exact: { order: exact, readings: roundedAll(last) },
      spectra: named(imagesOf(pair).map((name) => [name, spectrum(out[`${name}_size`], STOPS.length)])),
    };
  },

  async many(desk, question) {
    const pairs = [];
    let classes;
    for (const pair of question.pairs) {
      const asked = await desk.asked({ ...question, vis: pair.vis, tac: pair.tac });
      pairs.push(await desk.predicted(asked));
      classes = asked.head.classes;
    }
    return { classes, pairs };
  },

  async attention(desk, question) {
    const { pair, head } = await desk.asked(question);
    const names = imagesOf(pair).filter((name) => head.tokens[name]);
    if (!names.length) throw new Refused("This head has no MFFA, so there is no attention to show.");
    const out = await desk.run(
      head,
      pair,
      STOPS.map((p) => [p, p]),
    );
    const by = (/** @type {(name: Modality) => unknown} */ make) => named(names.map((name) => [name, make(name)]));
    const count = (/** @type {Modality} */ name) => out[`${name}_attention`].shape[2];
    const off = (/** @type {Modality} */ name) => [...out[`${name}_attention`].values].map((v) => v - 1 / count(name));
    const scale = names.flatMap(off).reduce((top, value) => Math.max(top, Math.abs(value)), 0) || 1;
    const coded = (/** @type {Modality} */ name) => Int8Array.from(off(name), (v) => Math.round((v / scale) * 127));
    return {
      tokens: by((name) => head.tokens[name]),
      count: by(count),
      off: by((name) => base64(new Uint8Array(coded(name).buffer))),
      scale,
      learned: head.learned,
    };
  },

  async familiar(desk, question) {
    const asked = await desk.asked({ ...question, profile: "" });
    const [looks, head] = [await desk.lookedAt(asked), await desk.head(question.head)];
    /** @type {Record<string, any>} */
    const images = {};
    for (const name of imagesOf(asked.before)) {
      const row = /** @type {Floats} */ (asked.before[name]);
      const [kind, number] = question[name].split(":");
      const near = await nearest(desk, head, name, row, kind === "row" ? Number(number) : -1);
      images[name] = { nearest: near, ...looks[name] };
      if (kind !== "image" || question.profile) continue;
      const [there] = await nearest(desk, head, OTHER[name], await desk.embedding(question[name], OTHER[name]), -1);
      images[name].strays = there.cosine > near[0].cosine;
    }
    return { images, of: head.training.of };
  },

  /** A profile of a visitor's pictures without labels, or more pictures for one. */
  async profile(desk, question) {
    await desk.sourceProfile();
    const channels = { ...desk.profileIn(question)?.channels };
    for (const name of IMAGES) {
      /** @type {Ref[]} */
      const refs = question[name === "vis" ? "photos" : "touches"] ?? [];
      if (!refs.length) continue;
      const fresh = channelsOf(await Promise.all(refs.map((ref) => desk.embedding(ref, name))));
      const before = channels[name];
      channels[name] = before ? joined(before, fresh) : fresh;
    }
    return desk.keepProfile({ channels });
  },

  async "save/sensor"(desk, question) {
    const profile = /** @type {SensorProfile} */ (desk.profileIn(question));
    return saved(profile, (await desk.about()).key);
  },

  /** What the head says of each lesson before and after teaching. */
  async teach(desk, question) {
    const lacking = missing(lessonsIn(question));
    if (lacking) throw new Refused(lacking);
    const { report, made } = await desk.learned(question);
    return { ...report, classes: made.classes };
  },

  async taught(desk, question) {
    await desk.reader(question);
    return { taught: taughtName(question) };
  },
};
