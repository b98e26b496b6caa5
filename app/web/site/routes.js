/** The routes that read one pair: the same reply as the server's. Runs in the worker. */

import { imagesOf, READINGS } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { base64 } from "../shared/text.js";
import { readingsOf } from "./desk.js";
import { JOURNEY } from "./journey.js";
import { nearest, rounded, rowOf, stacked, unit } from "./tensors.js";

/** @typedef {import("./desk.js").Desk} Desk */
const WARM = 3; // runs after which the browser has compiled the encoder
const named = Object.fromEntries;

/** Return all stops of p. @param {Desk} desk */
const stopsOf = async (desk) => {
  const { stops } = (await desk.about()).rules;
  return Array.from({ length: stops }, (_, k) => k / (stops - 1));
};

/** Return the first rows of moduli as a picture of bytes. @param {Tensor} moduli @param {number} rows */
function spectrum({ shape: [, width], values }, rows) {
  const shown = Array.from(values.subarray(0, rows * width));
  const top = shown.reduce((a, b) => Math.max(a, b)) || 1;
  const pixels = base64(Uint8Array.from(shown, (value) => Math.round((value / top) * 255)));
  return { rows, columns: width, width, top, pixels };
}

/** Return the nearest training pairs of the set, except the pair itself.
 * @param {Desk} desk @param {SiteHead} head @param {Modality} name @param {Floats} row @param {number} own */
async function nearestPairs(desk, { name: called, training: { index } }, name, row, own) {
  const { rules } = await desk.about();
  const rows = await desk.once(`training ${name} ${called}`, () =>
    Promise.all(index.map(async (pair) => unit(await desk.row(pair, name)))),
  );
  const near = nearest(rows, unit(row), rules.nearest, index.indexOf(own));
  return near.map(({ point, cosine }) => ({ pair: index[point], cosine: rounded(cosine, 4) }));
}

/** Return what some work gives, or why it was refused. @param {() => unknown} work */
async function quietly(work) {
  try {
    return await work();
  } catch (error) {
    if (!(error instanceof Refusal)) throw error;
    return { problem: error.message };
  }
}

/** Predict a pair at every stop and at the wanted p, as the server does. @param {Desk} desk @param {any} question */
async function predicted(desk, question) {
  const found = await desk.resolved(question);
  const { pair, order, head } = found;
  const { classes, learned, span, linear } = head;
  const stops = await stopsOf(desk);
  const exact = order ?? learned;
  const [out, images] = await Promise.all([desk.run(head, [pair], [...stops, exact]), desk.lookedAt(found)]);
  const each = stops.map((_, stop) => readingsOf(out, stop, pair));
  const readings = readingsOf(out, stops.length, pair);
  const shown = READINGS.filter((name) => readings[name]);
  return {
    ...{ classes, learned, span, linear, images },
    stops: named(shown.map((name) => [name, each.map((reading) => reading[name])])),
    exact: { order: exact, readings },
    spectra: named(imagesOf(pair).map((name) => [name, spectrum(out[`${name}_size`], stops.length)])),
  };
}

/** @type {Record<string, Route>} */
export const READING = {
  /** Fetch the encoder, and run what a first pair needs: later ones wait for no file and no compiler. */
  async warm(desk) {
    await desk.runtime(); // with the head, before the encoder
    await desk.encoder();
    const blank = { pixels: new Uint8Array(3 * 320 * 240), width: 320, height: 240 };
    for (let time = 0; time < WARM; time++) {
      const pair = await desk.asEither(blank);
      const head = await desk.head();
      await Promise.all([desk.run(head, [pair], [null]), desk.lookedAt({ pair, head, order: null })]);
    }
    return {};
  },

  /** A prediction now and at every stop, with the spectra; and what else is wanted `with` it. */
  async pair(desk, question, sent) {
    const wanted = /** @type {string[]} */ (question.with ?? []);
    const reply = await predicted(desk, question);
    const by = { ...question, head: "" };
    /** @type {Record<string, () => unknown>} */
    const parts = {
      familiar: () => READING.familiar(desk, question, sent),
      journey: () => JOURNEY.journey(desk, by, sent),
      moving: () => predicted(desk, by),
    };
    const names = wanted.filter((name) => parts[name] && (name !== "moving" || reply.linear));
    const found = names.map(async (name) => [name, await quietly(parts[name])]);
    return { ...reply, ...named(await Promise.all(found)) };
  },

  async attention(desk, question) {
    const { pair, head } = await desk.resolved(question);
    const names = imagesOf(pair);
    if (!head.attends) throw new Refusal("This head has no MFFA, so there is no attention to show.");
    const out = await desk.run(head, [pair], await stopsOf(desk));
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
    const { pair, head } = await desk.resolved(question);
    const images = imagesOf(pair).map(async (name) => {
      const own = await desk.rowOf(question[name]);
      return [name, { nearest: await nearestPairs(desk, head, name, /** @type {Floats} */ (pair[name]), own) }];
    });
    return { images: named(await Promise.all(images)), of: head.training.of };
  },
};
