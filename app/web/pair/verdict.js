/** The prediction of one pair in words: both, photo only, touch only. Data in, markup out. */

import { classColour } from "../shared/palette.js";
import { describe } from "./own-pictures.js";
import {
  button,
  capital,
  headed,
  hint,
  html,
  IMAGES,
  imagesOf,
  NO_CLASS,
  OTHER,
  opener,
  paragraph,
  percent,
  READINGS,
  row,
  signed,
  TERMS,
  table,
} from "./parts.js";
import { tileOf } from "./slots.js";
import { labelOf, mixed } from "./state.js";

/** The class with the largest probability, and that probability. @param {string[]} classes @param {number[]} row */
function best(classes, row) {
  const at = row.indexOf(Math.max(...row));
  return { label: classes[at], share: row[at] };
}

const ABSENT = { row: [], label: "", share: 0, used: [], strange: [], guess: false };

/** What each reading of a pair predicts; nothing without its images.
 * @param {{classes: string[], readings: Partial<Probabilities>, images?: Guesses}} prediction @returns {Said[]} */
export function readingsOf({ classes, readings, images }) {
  const given = imagesOf(readings);
  return READINGS.map((reading) => {
    const row = readings[reading];
    if (!row || (reading === "fused" && given.length < 2)) return { reading, ...ABSENT };
    const used = given.filter((name) => [name, "fused"].includes(reading));
    const strange = used.filter((name) => images?.[name]?.guess);
    return { reading, row, ...best(classes, row), used, strange, guess: strange.length > 0 };
  });
}

/** Reading -> predicted class; "fused" only where both images are there.
 * @param {string[]} classes @param {Probabilities} readings @returns {Partial<Record<Reading, string>>} */
export const said = (classes, readings) =>
  Object.fromEntries(
    readingsOf({ classes, readings }).flatMap(({ reading, label }) => (label ? [[reading, label]] : [])),
  );

/** A reading in a cell: its class, and a figure unless it is a guess. @param {Said} said */
export const brief = ({ label, share, guess }) =>
  label ? html`${label}${guess ? "?" : html` <b>${percent(share)}</b>`}` : "–";

/** Cards in a row. @param {Said[]} all @param {(one: Said) => unknown} words */
const cardsOf = (all, words) =>
  html`<div class="readings">${all.map((one) => {
    const absent = one.reading !== "fused" && html` title="The other image is absent"`;
    return html`<article class="reading ${!one.label && "none"}" data-reading="${one.reading}"><h3${absent}>${signed(one.reading)}</h3>${words(one)}</article>`;
  })}</div>`;

/** A prediction by what `readingsOf` takes. @param {Answer} answer */
export const readingsIn = ({ classes, exact, images }) => readingsOf({ classes, ...exact, images });

/** Three cards. `truths`: the class of each image, if known; `yours`: the lessons decide what is familiar.
 * @param {Answer} answer @param {Truths} truths @param {boolean} [yours] */
export function cards(answer, truths, yours) {
  const [given] = imagesOf(answer.exact.readings);
  return cardsOf(readingsIn(answer), (one) => {
    if (one.label) return [called(one, yours), judged(one, truths, answer.classes)];
    if (one.reading === "fused") return hint(`Add the ${TERMS[OTHER[given]].one} to see both together.`);
    return hint(`No ${TERMS[one.reading].one} here.`);
  });
}

/** The prediction of the newest frames of the cameras. @param {Frame} frame */
export function liveHtml(frame) {
  const there = readingsOf(frame).filter(({ label }) => label);
  const [words, below] = frame.idle
    ? [null, "No contact: press the sensor on something."]
    : [cardsOf(there, (one) => called(one, frame.yours)), "Everything below belongs to the pair chosen before."];
  return html`<p><b class="tag">live</b></p>${words}${hint(below)}`;
}

/** The panel of the prediction. @param {PairTab} tab */
export function verdictHtml(tab) {
  const { answer, question, frame, busy } = tab;
  if (frame) return liveHtml(frame);
  if (!answer)
    return hint(
      busy
        ? "Predicting… the first prediction takes a few seconds."
        : "Choose a pair to see the prediction. One image is enough.",
    );
  const label = labelOf(tab);
  const truths = Object.fromEntries(IMAGES.map((name) => [name, describe(tab, tab[name] ?? "").truth || label]));
  const by =
    tab.taught &&
    paragraph(
      "taught-now",
      html`<b class="tag">taught</b> by your ${label ? "other pairs; this one was left out" : "pairs"}.`,
    );
  const mix = mixed(tab) && paragraph("made-of", "Two pictures of different pairs: not counted, not taught.");
  return html`${by}${madeOf(truths) ?? mix}${cards(answer, truths, Boolean(question?.lessons))}`;
}

/** A prediction in words; a guess has no figure. @param {Said} said @param {boolean} [yours] */
function called({ label, share, strange }, yours) {
  if (!strange.length) return paragraph("said", label, html` <b>${percent(share)}</b>`);
  const what = strange.length > 1 ? "Both images are" : `The ${TERMS[strange[0]].one} is`;
  const seen = yours ? "the pictures that you labelled" : "anything it has seen";
  return html`<p class="said guess">${label}?</p><p class="guessed"><b>This is a guess.</b> ${what} unlike ${seen}.</p>`;
}

/** Whether a prediction is right; for a mixed pair, which image it follows.
 * @param {Pick<Said, "label" | "used">} said @param {Truths} truths @param {string[]} classes */
export function judged({ label, used }, truths, classes) {
  const [truth, other = truth] = used.map((name) => truths[name]);
  if (!truth || !other) return null; // a visitor's picture has no class of its own
  if (truth !== other) {
    const follows = used.find((name) => truths[name] === label);
    return paragraph("follows", `It follows ${follows ? `the ${TERMS[follows].one}` : "neither"}.`);
  }
  if (label === truth) return paragraph("right", "✓ right");
  return paragraph("wrong", `✗ it is ${truth}`, !classes.includes(truth) && ", a class this head has not learned");
}

/** One line above the cards: the two classes of a mixed pair. @param {Truths} truths */
export const madeOf = ({ vis, tac }) =>
  vis && tac && vis !== tac
    ? paragraph("made-of", html`${TERMS.vis.title}: <b>${vis}</b>. ${TERMS.tac.title}: <b>${tac}</b>.`)
    : null;

/** Every class under every reading; columns of guesses are grey. @param {Answer & Pick<Predicted, "learned" | "linear">} answer */
export function classTable(answer) {
  const columns = readingsIn(answer).filter(({ label }) => label);
  const [{ label: winner }] = columns; // the first is both, if both are there
  const head = columns.map(({ reading, guess }) => html`${signed(reading)}${guess && html` <small>(guess)</small>`}`);
  const rows = answer.classes.map((name, k) => {
    const cells = columns.map(
      ({ reading, row: shares, guess }) =>
        html`<td data-reading="${reading}" class="${guess && "of-guess"}"><span class="bar ${reading}" style="--share:${shares[k]}"></span><span class="share">${percent(shares[k], 1)}</span></td>`,
    );
    return row(html`<i class="${name === winner && "best"}" style="background:${classColour(k)}"></i>${name}`, cells);
  });
  const grey =
    columns.some(({ guess }) => guess) &&
    hint(
      "Grey: figures for a guess. They were calibrated on images like the training images, so they mean little here.",
    );
  const at = answer.linear
    ? "By linear maps, in which p has no part."
    : `At the learned p = ${answer.learned.toFixed(4)}.`;
  return html`${table("Every class", ["Class", ...head], rows)}${grey}${hint(at)}`;
}

/** The prediction in one sentence, for a screen reader. @param {Answer} answer */
export function spoken(answer) {
  const [{ label, share, guess }] = readingsIn(answer).filter((said) => said.label);
  return guess ? `${label}? This is a guess.` : `${label}, ${percent(share)}`;
}

/** The same pair by other heads; a reading that is a guess has no figure. All heads share the encoder.
 * @param {Answer} answer @param {Rival[]} others */
export function rivalsHtml(answer, others) {
  const lines = [{ ...answer, label: "this head" }, ...others].map((one) => {
    if ("problem" in one) return row(html`${one.label}`, [html`<td colspan="3">${one.problem}</td>`]);
    const cells = readingsIn({ ...one, images: answer.images }).map(
      (said) => html`<td class="${said.guess && "of-guess"}">${brief(said)}</td>`,
    );
    return row(html`${one.label} <small>p = ${one.exact.order.toFixed(3)}</small>`, cells);
  });
  const head = ["Head", ...READINGS.map((reading) => signed(reading))];
  return html`${headed("The same pair, other heads", hint("Each at its own learned p."))}${table("Predictions of several heads", head, lines)}`;
}

const SIDE = 104; // CSS pixels of a neighbour: large enough to see what it is
const SAME = 0.9999; // the cosine of an image with itself, rounded

/** One sentence on an image, from its quantile among the training images.
 * @param {Modality} modality @param {Partial<Familiarity>} image */
export function sentence(modality, { words, guess, cosine = 0, quantile = 0 }, yours = false) {
  const { one, many } = TERMS[modality];
  if (words === undefined) return `This head has no record of how familiar a ${one} is.`;
  if (yours)
    return guess ? `Farther from your labelled ${many} than they are from one another.` : `Like your labelled ${many}.`;
  if (cosine > SAME) return `Familiar: it is one of the training ${many}.`;
  const farther = Math.round(100 * quantile);
  const count = farther < 1 ? "fewer than 1" : farther > 99 ? "more than 99" : farther;
  return `${capital(words)}: ${count} of 100 training ${many} ${count === 1 ? "has" : "have"} a farther neighbour.`;
}

/** A question about pictures that are nearer to the training images of the other slot; null if none is.
 * @param {Near} images @param {Pair} pair */
export function swapHtml(images, { vis, tac }) {
  const there = imagesOf(images);
  if (!there.length || !there.every((name) => images[name]?.strays)) return null;
  const [{ one, many }, other] = [there[0], OTHER[there[0]]].map((name) => TERMS[name]);
  const [words, act] =
    there.length > 1
      ? [
          `Are these two swapped? The ${one} is nearer to the training ${other.many}, the ${other.one} to the ${many}.`,
          "Swap them",
        ]
      : [`Is this a ${other.one}? It is nearer to those than to the training ${many}.`, "Move it"];
  return paragraph("note swapped", words, " ", opener(act, { vis: tac, tac: vis }));
}

/** The panel: familiarity and nearest training pairs; `set` has thumbnails and names of domains and classes, once loaded.
 * @param {Replies["familiar"]} near @param {Predicted["images"]} images @param {PairSet} set @param {boolean} [yours] */
export function familiarHtml(near, images, set, yours) {
  const looks = imagesOf(near.images).map((modality) => {
    /** @type {Partial<Familiarity>} */
    const image = images[modality] ?? {};
    const mark = image.guess ? "wrong" : "right";
    const known = image.quantile !== undefined;
    return html`<div class="look" data-modality="${modality}"><h4>${signed(modality, capital(TERMS[modality].one))}</h4>
      ${paragraph(known ? mark : "hint", sentence(modality, image, yours))}
      ${known && html`<div class="meter" aria-hidden="true"><i class="${mark}" style="--at:${image.quantile}"></i></div>`}
      <div class="nearest">${near.images[modality]?.nearest.map((one) => neighbour(one, modality, set))}</div></div>`;
  });
  return html`${headed("Seen before?", hint(`Nearest: ${near.of}`))}<div class="looked">${looks}</div>`;
}

/** @param {{pair: number, cosine: number}} near @param {Modality} modality @param {PairSet} set */
function neighbour({ pair, cosine }, modality, set) {
  const { frames } = set;
  const { one } = TERMS[modality];
  const label = frames?.classes[frames.label[pair]] ?? NO_CLASS;
  const name = label === NO_CLASS ? "" : label;
  const where = frames && ` of ${frames.domains[frames.domain[pair]]}`;
  const picture = tileOf(set, pair, modality, SIDE, name ? `${one} of ${name}` : one);
  return button(
    "pin",
    html`${picture}<small><b>${name || `pair ${pair}`}</b> ${cosine.toFixed(2)}</small>`,
    html`data-pair="${pair}" title="Open this pair${where}"`,
  );
}
