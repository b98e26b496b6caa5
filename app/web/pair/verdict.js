/** The prediction of one pair in words: both, photo only, touch only. Data in, markup out. */

import { classOf, domainOf } from "../shared/frames.js";
import { best } from "../shared/numbers.js";
import { classColour } from "../shared/palette.js";
import { sensorOf } from "../shared/tables.js";
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
import { cautionOf } from "./reader.js";
import { tileOf } from "./slots.js";
import { labelOf, mixed } from "./state.js";

const LIVE = "image:"; // frames of cameras are the visitor's own pictures
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
    return html`<article class="reading ${!one.label && "none"}" data-reading="${one.reading}">
      <h3${absent}>${signed(one.reading)}</h3>${words(one)}</article>`;
  })}</div>`;

/** A prediction by what `readingsOf` takes. @param {Answer} answer */
export const readingsIn = ({ classes, exact, images }) => readingsOf({ classes, ...exact, images });

/** Three cards. `truths`: the class of each image, if known; `yours`: the lessons decide what is familiar; `caution`:
 * what to know of a reading.
 * @param {Answer} answer @param {Truths} truths @param {boolean} [yours]
 * @param {(one: Said) => Html | null} [caution] */
export function cards(answer, truths, yours, caution = () => null) {
  const [given] = imagesOf(answer.exact.readings);
  return cardsOf(readingsIn(answer), (one) => {
    if (one.label) return [called(one, yours, caution), judged(one, truths, answer.classes)];
    if (one.reading === "fused") return hint(`Add the ${TERMS[OTHER[given]].one} to predict from both images.`);
    return hint(`This pair has no ${TERMS[one.reading].one}.`);
  });
}

/** The prediction of the newest frames of the cameras. @param {Frame} frame
 * @param {(one: Said) => Html | null} [caution] */
export function liveHtml(frame, caution) {
  const there = readingsOf(frame).filter(({ label }) => label);
  const [words, below] = frame.idle
    ? [null, "There is no contact. Press the sensor on something."]
    : [
        cardsOf(there, (one) => called(one, frame.yours, caution)),
        "The panels below belong to the pair chosen before.",
      ];
  return html`<p><b class="tag">live</b></p>${words}${hint(below)}`;
}

/** The panel of the prediction. @param {PairTab} tab */
export function verdictHtml(tab) {
  const { answer, question, frame, busy } = tab;
  if (frame) return liveHtml(frame, (said) => cautionOf({ ...tab, vis: LIVE, tac: LIVE }, said));
  if (!answer)
    return hint(
      busy
        ? "Predicting… The first prediction takes a few seconds."
        : "Choose a pair to see the prediction. One image is enough.",
    );
  const label = labelOf(tab);
  const truths = Object.fromEntries(IMAGES.map((name) => [name, describe(tab, tab[name] ?? "").truth || label]));
  const by =
    tab.taught &&
    paragraph(
      "taught-now",
      html`<b class="tag">taught</b> The head was taught with
        your ${label ? "other pairs; this one was left out" : "pairs"}.`,
    );
  const mix =
    mixed(tab) &&
    paragraph("made-of", "These pictures come from different pairs, so they are neither counted nor taught.");
  return html`${by}${madeOf(truths) ?? mix}
    ${cards(answer, truths, Boolean(question?.lessons), (said) => cautionOf(tab, said))}`;
}

/** A prediction in words; a guess has no figure. @param {Said} said @param {boolean} [yours]
 * @param {(one: Said) => Html | null} [caution] */
function called(said, yours, caution = () => null) {
  const { label, share, strange } = said;
  const note = caution(said);
  if (!strange.length)
    return html`${paragraph("said", label, html` <b>${percent(share)}</b>`)}${note && paragraph("caution", note)}`;
  const what = strange.length > 1 ? "Both images are" : `The ${TERMS[strange[0]].one} is`;
  const seen = yours ? "the pictures that you labelled" : "all training images";
  return html`<p class="said guess">${label}?</p>
    <p class="guessed"><b>This is a guess.</b> ${what} unlike ${seen}.</p>`;
}

/** Whether a prediction is right; for a mixed pair, which image it follows.
 * @param {Pick<Said, "label" | "used">} said @param {Truths} truths @param {string[]} classes */
export function judged({ label, used }, truths, classes) {
  const [truth, other = truth] = used.map((name) => truths[name]);
  if (!truth || !other) return null; // a visitor's picture has no class of its own
  if (truth !== other) {
    const follows = used.find((name) => truths[name] === label);
    return paragraph(
      "follows",
      follows ? `The prediction follows the ${TERMS[follows].one}.` : "The prediction follows neither image.",
    );
  }
  if (label === truth) return paragraph("right", "✓ correct");
  return paragraph("wrong", `✗ it is ${truth}`, !classes.includes(truth) && ", a class that the head does not know");
}

/** One line above the cards: the two classes of a mixed pair. @param {Truths} truths */
export const madeOf = ({ vis, tac }) =>
  vis && tac && vis !== tac
    ? paragraph("made-of", html`${TERMS.vis.title}: <b>${vis}</b>. ${TERMS.tac.title}: <b>${tac}</b>.`)
    : null;

/** Every class under every reading; columns of guesses are grey.
 * @param {Answer & Pick<Predicted, "learned" | "linear">} answer */
export function classTable(answer) {
  const columns = readingsIn(answer).filter(({ label }) => label);
  const [{ label: winner }] = columns; // the first is both, if both are there
  const head = columns.map(({ reading, guess }) => html`${signed(reading)}${guess && html` <small>(guess)</small>`}`);
  const rows = answer.classes.map((name, k) => {
    const cells = columns.map(
      ({ reading, row: shares, guess }) =>
        html`<td data-reading="${reading}" class="${guess && "of-guess"}"><span class="bar ${reading}"
          style="--share:${shares[k]}"></span><span class="share">${percent(shares[k], 1)}</span></td>`,
    );
    return row(html`<i class="${name === winner && "best"}" style="background:${classColour(k)}"></i>${name}`, cells);
  });
  const grey =
    columns.some(({ guess }) => guess) &&
    hint(html`Grey figures belong to a guess. They mean little, because they were calibrated on images like the training
      images.`);
  const at = answer.linear
    ? "Linear maps make this prediction; they do not use p."
    : `The prediction uses the learned p = ${answer.learned.toFixed(4)}.`;
  return html`${table("Every class", ["Class", ...head], rows)}${grey}${hint(at)}`;
}

/** The prediction in a sentence or two, for a screen reader. @param {Answer} answer
 * @param {(one: Said) => Html | null} [caution] */
export function spoken(answer, caution = () => null) {
  const [said] = readingsIn(answer).filter((said) => said.label);
  const { label, share, guess } = said;
  return guess ? html`${label}? This is a guess.` : html`${label}, ${percent(share)}. ${caution(said)}`;
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
  return html`${headed("Predictions of other heads for this pair", hint("Each head uses its own learned p."))}
    ${table("Predictions of several heads", head, lines)}`;
}

const SIDE = 104; // CSS pixels of a neighbour: large enough to see what it is
const JUST = 0.1; // from this quantile on, an image is clearly similar to the training images
const SAME = 0.9999; // the cosine of an image with itself, rounded

/** One sentence on an image, from its quantile among the training images.
 * @param {Modality} modality @param {Partial<Familiarity>} image */
export function sentence(modality, { words, guess, cosine = 0, quantile = 0 }, yours = false) {
  const { one, many } = TERMS[modality];
  if (words === undefined) return `The head has no record of how familiar a ${one} is.`;
  if (yours)
    return guess
      ? `Unlike your labelled ${many}, which are more similar to one another.`
      : `Similar to your labelled ${many}.`;
  if (cosine > SAME) return `This is one of the training ${many}.`;
  const unusual = Math.round(100 * quantile);
  const count = unusual < 1 ? "fewer than 1" : unusual > 99 ? "more than 99" : unusual;
  const rest = `${count} of 100 ${count === 1 ? "is" : "are"} more unusual.`;
  if (guess) return `Unlike the training ${many}: ${unusual < 1 ? "" : "only "}${rest}`;
  return `Similar to the training ${many}${quantile < JUST ? ", but only just" : ""}: ${rest}`;
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
          html`Are photo and touch swapped? The ${one} is more similar to the training ${other.many}, the ${other.one}
            to the training ${many}.`,
          "Swap them",
        ]
      : [
          `Is this a ${other.one}? It is more similar to the training ${other.many} than to the training ${many}.`,
          "Move it",
        ];
  return paragraph("note swapped", words, " ", opener(act, { vis: tac, tac: vis }));
}

/** The panel: familiarity and nearest training pairs; `set` has thumbnails and names of domains and classes, once
 * loaded.
 * @param {Replies["familiar"]} near @param {Predicted["images"]} images @param {PairSet} set
 * @param {boolean} [yours] */
export function familiarHtml(near, images, set, yours) {
  const looks = imagesOf(near.images).map((modality) => {
    /** @type {Partial<Familiarity>} */
    const image = images[modality] ?? {};
    const mark = image.guess ? "wrong" : "right";
    const known = image.quantile !== undefined;
    return html`<div class="look" data-modality="${modality}"><h4>${signed(modality, capital(TERMS[modality].one))}</h4>
      ${paragraph(image.guess ? "wrong" : "hint", sentence(modality, image, yours))}
      ${
        known &&
        html`<div class="meter" aria-hidden="true"><i class="${mark}"
        style="--at:${image.quantile}"></i></div>`
      }
      <div class="nearest">${near.images[modality]?.nearest.map((one) => neighbour(one, modality, set))}</div></div>`;
  });
  return html`${headed("Is it similar to the training images?", hint(`Nearest among ${near.of}`))}
    <div class="looked">${looks}</div>`;
}

/** @param {{pair: number, cosine: number}} near @param {Modality} modality @param {PairSet} set */
function neighbour({ pair, cosine }, modality, set) {
  const { frames } = set;
  const { one } = TERMS[modality];
  const name = frames ? classOf(frames, pair).replace(NO_CLASS, "") : "";
  const where = frames && ` of ${sensorOf(domainOf(frames, pair))}`;
  const picture = tileOf(set, pair, modality, SIDE, name ? `${one} of ${name}` : one);
  return button(
    "pin",
    html`${picture}<small><b>${name || `pair ${pair}`}</b> ${cosine.toFixed(2)}</small>`,
    html`data-pair="${pair}" title="Open this pair${where}"`,
  );
}
