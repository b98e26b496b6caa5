/** The routes of Try a pair whose body is a question: the same reply as the server's. Runs in the worker. */

import { IMAGES, imagesOf, OTHER, READINGS } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { base64 } from "../shared/text.js";
import { readingsOf, roundedAll } from "./desk.js";
import { saved } from "./profiles.js";
import { PAIR } from "./rules.js";
import { nearest, rounded, roundedRow, rowOf, stacked, unit } from "./tensors.js";

/** @typedef {import("./desk.js").Desk} Desk */
const STOPS = Array.from({ length: PAIR.STOPS }, (_, k) => k / (PAIR.STOPS - 1));
const named = Object.fromEntries;

/** Moduli (P, D) as a picture of bytes, of neighbours the largest. @param {Tensor} moduli @param {number} rows */
export function spectrum({ shape: [, width], values }, rows) {
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

/** The nearest training pairs of the set, except the pair itself.
 * @param {Desk} desk @param {SiteHead} head @param {Modality} name @param {Floats} row @param {number} own */
async function nearestPairs(desk, { name: called, training: { index } }, name, row, own = -1) {
  const rows = await desk.once(`training ${name} ${called}`, () =>
    Promise.all(index.map(async (pair) => unit(await desk.row(pair, name)))),
  );
  const near = nearest(rows, unit(row), PAIR.NEAREST, index.indexOf(own));
  return near.map(({ point, cosine }) => ({ pair: index[point], cosine: rounded(cosine, 4) }));
}

/** @type {Record<string, Route>} */
export const QUESTIONS = {
  /** A prediction now and at every stop, with the spectra. */
  async pair(desk, question) {
    const asked = await desk.asked(question);
    const { pair, order, head } = asked;
    const exact = order ?? head.learned;
    const [out, images] = await Promise.all([desk.run(head, [pair], [...STOPS, exact]), desk.lookedAt(asked)]);
    const each = STOPS.map((_, stop) => readingsOf(out, stop, pair));
    const last = readingsOf(out, STOPS.length, pair);
    const shown = READINGS.filter((name) => last[name]);
    return {
      classes: head.classes,
      learned: head.learned,
      span: head.span,
      linear: head.linear,
      stops: named(shown.map((name) => [name, each.map((one) => roundedRow(one[name]))])),
      exact: { order: exact, readings: roundedAll(last) },
      spectra: named(imagesOf(pair).map((name) => [name, spectrum(out[`${name}_size`], STOPS.length)])),
      images,
    };
  },

  async many(desk, question) {
    const pairs = [];
    let classes;
    for (const { vis, tac } of question.pairs) {
      const asked = await desk.asked({ ...question, vis, tac });
      pairs.push(await desk.predicted(asked));
      classes = asked.head.classes;
    }
    return { classes, pairs };
  },

  async attention(desk, question) {
    const { pair, head } = await desk.asked(question);
    const names = imagesOf(pair);
    if (!head.attends) throw new Refusal("This head has no MFFA, so there is no attention to show.");
    const out = await desk.run(head, [pair], STOPS);
    const weights = names.map((name) => out[`${name}_attention`]);
    const count = weights[0].shape[2];
    const [coded, scale] = await desk.rule("attention", stacked(weights.map(({ values }) => values)), 1 / count);
    return {
      count: named(names.map((name) => [name, count])),
      off: named(names.map((name, i) => [name, base64(Uint8Array.from(rowOf(coded, i)))])),
      scale: scale.values[0],
    };
  },

  async familiar(desk, question) {
    const { before } = await desk.pairOf({ ...question, profile: "" });
    const head = await desk.head(question.head);
    /** @type {Record<string, any>} */
    const images = {};
    for (const name of imagesOf(before)) {
      const ref = question[name];
      const near = await nearestPairs(desk, head, name, /** @type {Floats} */ (before[name]), await desk.rowOf(ref));
      images[name] = { nearest: near };
      if (!ref.startsWith("image:") || question.profile) continue;
      const [there] = await nearestPairs(desk, head, OTHER[name], await desk.embedding(ref, OTHER[name]));
      images[name].strays = there.cosine > near[0].cosine;
    }
    return { images, of: head.training.of };
  },

  /** A profile of a visitor's pictures without labels, or more pictures for one. */
  async profile(desk, question) {
    await desk.sourceProfile();
    const channels = { ...desk.profileIn(question)?.channels };
    const refs = { vis: question.photos ?? [], tac: question.touches ?? [] };
    for (const name of IMAGES) {
      for (const ref of refs[name]) {
        channels[name] = await desk.joined(await desk.embedding(ref, name), channels[name]);
      }
    }
    return desk.keepProfile({ channels });
  },

  async "save/sensor"(desk, question) {
    return saved(/** @type {SensorProfile} */ (desk.profileIn(question)), (await desk.about()).key);
  },

  /** What the head predicts for each lesson before and after teaching. */
  async teach(desk, question) {
    return (await desk.learned(question)).report;
  },

  async taught(desk, question) {
    return { taught: (await desk.learned(question)).name };
  },
};
