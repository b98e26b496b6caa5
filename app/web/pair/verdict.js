/** The prediction of one pair in words: both, photo only, touch only. Text in, HTML out. */

import { thumbnail } from "../shared/card.js";
import { imagesOf, OTHER } from "../shared/images.js";
import { classColour } from "../shared/palette.js";
import { each, escaped, NO_CLASS, percent, row, table } from "../shared/text.js";

/** The readings and their names. A branch inside a pair is not a reading. */
export const READINGS = [
  ["fused", "Both", "both"],
  ["vis", "Photo only", "vis"],
  ["tac", "Touch only", "tac"],
];
/** The two images of a pair, in words. */
export const TERMS = {
  vis: { title: "Photo", what: "VIS", one: "photo", many: "photos" },
  tac: { title: "Touch", what: "TAC", one: "touch", many: "touch images" },
};

/** In a set of signals, a pair is two recordings of one signal: no photo and no touch. */
export function speakOfSignals() {
  for (const [name, which] of [
    ["vis", "first"],
    ["tac", "second"],
  ]) {
    const title = which[0].toUpperCase() + which.slice(1);
    Object.assign(TERMS[name], {
      title,
      what: name.toUpperCase(),
      one: `${which} recording`,
      many: `${which} recordings`,
    });
    for (const one of READINGS) if (one[0] === name) one[1] = `${title} only`;
  }
}

/** The class with the largest probability, and that probability. */
export function best(classes, row) {
  const at = row.indexOf(Math.max(...row));
  return { label: classes[at], share: row[at] };
}

/** Reading -> predicted class; "fused" only where both images are there. */
export function said(classes, readings) {
  const there = READINGS.filter(([name]) => readings[name] && (name !== "fused" || (readings.vis && readings.tac)));
  return Object.fromEntries(there.map(([name]) => [name, best(classes, readings[name]).label]));
}

/** The images of a reading, among those present. */
export const usedBy = (reading, given) => (reading === "fused" ? given : given.filter((name) => name === reading));

/** The images of a reading that are unlike the training images, which make it a guess. */
export const unlike = (reading, given, images) => usedBy(reading, given).filter((name) => images?.[name]?.guess);

/** What each reading of a pair says: {title, sign, label, share, strange: images that make it a guess}; of a reading
 * without its images the names only. @returns {any[]} */
export function readingsOf({ classes, readings, images }) {
  const given = imagesOf(readings);
  return READINGS.map(([reading, title, sign]) => {
    const names = { reading, title, sign, row: readings[reading] };
    if (!names.row || (reading === "fused" && given.length < 2)) return names;
    const strange = unlike(reading, given, images);
    return { ...names, ...best(classes, names.row), used: usedBy(reading, given), strange, guess: strange.length > 0 };
  });
}

/** A reading in a cell: its class, and a figure unless it is a guess. */
export const brief = ({ label, share, guess }) =>
  label ? `${escaped(label)}${guess ? "?" : ` <b>${percent(share)}</b>`}` : "–";

/**
 * Three cards. `answer`: the server's predictions; `familiar`: familiarity of the images, null until
 * it arrives; `truths`: the class of each image, if known.
 */
export function cards({ classes, exact: { readings } }, familiar, truths) {
  const [given] = imagesOf(readings);
  const card = ({ reading, title, sign, label, row, used, strange }) => {
    const absent = reading === "fused" ? "" : ' title="The other image is absent"';
    const missing = row
      ? `Add the ${TERMS[OTHER[given]].one} to see both together.`
      : `No ${TERMS[reading]?.one} here.`;
    const words = label
      ? called(classes, row, strange, familiar) + judged(label, used, truths, classes)
      : `<p class="hint">${missing}</p>`;
    return `<article class="reading${label ? "" : " none"}" data-reading="${sign}"><h3${absent}><span class="sign ${sign}"></span>${title}</h3>${words}</article>`;
  };
  return `<div class="readings">${each(readingsOf({ classes, readings, images: familiar?.images }), card)}</div>`;
}

/** A prediction in words; its figure waits for the familiarity, which may make it a guess. */
export function called(classes, row, strange, familiar) {
  const { label, share } = best(classes, row);
  if (!familiar) return `<p class="said">${escaped(label)}</p>`;
  if (!strange.length) return `<p class="said">${escaped(label)} <b>${percent(share)}</b></p>`;
  const what = strange.length > 1 ? "Both images are" : `The ${TERMS[strange[0]].one} is`;
  const seen = familiar.yours ? "the pictures that you labelled" : "anything it has seen";
  return `<p class="said guess">${escaped(label)}?</p><p class="guessed"><b>This is a guess.</b> ${what} unlike ${seen}.</p>`;
}

/** Whether a prediction is right; for a mixed pair, which image it follows. */
export function judged(said, used, truths, classes) {
  const known = used.map((name) => truths[name]).filter(Boolean);
  if (!known.length || known.length < used.length) return ""; // a visitor's picture has no class of its own
  if (known.length > 1 && known[0] !== known[1]) {
    const follows = used.filter((name) => truths[name] === said);
    return `<p class="follows">${follows.length ? `It follows the ${TERMS[follows[0]].one}.` : "It follows neither."}</p>`;
  }
  if (said === known[0]) return '<p class="right">✓ right</p>';
  const lacks = classes.includes(known[0]) ? "" : ", a class this head has not learned";
  return `<p class="wrong">✗ it is ${escaped(known[0])}${lacks}</p>`;
}

/** One line above the cards: the two classes of a mixed pair. */
export function madeOf({ vis, tac }) {
  if (!vis || !tac || vis === tac) return "";
  return `<p class="made-of">${TERMS.vis.title}: <b>${escaped(vis)}</b>. ${TERMS.tac.title}: <b>${escaped(tac)}</b>.</p>`;
}

/** Every class under every reading; columns of guesses are grey. `images`: familiarity of each image. */
export function classTable(classes, readings, images) {
  const shown = readingsOf({ classes, readings, images }).filter(({ row }) => row);
  const several = shown.length > 2 ? shown : shown.filter(({ reading }) => reading !== "fused");
  const winner = best(classes, readings.fused).label;
  const grey = several.some(({ guess }) => guess);
  const head = each(
    several,
    ({ sign, title, guess }) =>
      `<th scope="col"><span class="sign ${sign}"></span>${title}${guess ? " <small>(guess)</small>" : ""}</th>`,
  );
  const cell = ({ reading, sign, row, guess }, k) =>
    `<td data-reading="${reading}"${guess ? ' class="of-guess"' : ""}><span class="bar ${sign}" style="--share:${row[k]}"></span><span class="share">${percent(row[k], 1)}</span></td>`;
  const rows = each(
    classes,
    (name, k) =>
      `<tr class="${name === winner ? "best" : ""}"><th scope="row"><i style="background:${classColour(k)}"></i>${escaped(name)}</th>${each(several, (one) => cell(one, k))}</tr>`,
  );
  return `<table class="bar-table"><thead><tr><th scope="col">Class</th>${head}</tr></thead><tbody>${rows}</tbody></table>${grey ? '<p class="hint">Grey: figures for a guess. They were calibrated on images like the training images, so they mean little here.</p>' : ""}`;
}

/** The prediction in one sentence, for a screen reader. */
export function spoken(answer, familiar) {
  const { readings } = answer.exact;
  const given = imagesOf(readings);
  const { label, share } = best(answer.classes, readings.fused);
  return unlike("fused", given, familiar.images).length ? `${label}? This is a guess.` : `${label}, ${percent(share)}`;
}

/** The same pair by other heads. `images`: familiarity of each image; a reading that is a guess has no figure. All heads share the encoder. */
export function rivalsHtml(answer, others, images) {
  const head = ["Head", ...READINGS.map(([, title, sign]) => `<span class="sign ${sign}"></span>${title}`)];
  const line = ({ label, problem, classes, learned, exact }) =>
    problem
      ? row(escaped(label), [`<td colspan="3">${escaped(problem)}</td>`])
      : row(
          `${escaped(label)} <small>p = ${learned.toFixed(3)}</small>`,
          readingsOf({ classes, readings: exact.readings, images }).map(
            (one) => `<td${one.guess ? ' class="of-guess"' : ""}>${brief(one)}</td>`,
          ),
        );
  return `<header><h3>The same pair, other heads</h3><p class="hint">Each at its own learned p.</p></header>${table("Predictions of several heads", head, [{ ...answer, label: "this head" }, ...others].map(line))}`;
}

const SIDE = 104; // CSS pixels of a neighbour: large enough to see what it is
const SAME = 0.9999; // the cosine of an image with itself, rounded

/** One sentence on an image, from its quantile among the training images. */
export function sentence(modality, image, yours = false) {
  const { one, many } = TERMS[modality];
  if (yours && image.words !== undefined)
    return image.guess
      ? `Farther from your labelled ${many} than they are from one another.`
      : `Like your labelled ${many}.`;
  if (image.words === undefined) return `This head has no record of how familiar a ${one} is.`;
  if (image.cosine > SAME) return `Familiar: it is one of the training ${many}.`;
  const farther = Math.round(100 * image.quantile);
  const count = farther < 1 ? "fewer than 1" : farther > 99 ? "more than 99" : farther;
  return `${capital(image.words)}: ${count} of 100 training ${many} ${count === 1 ? "has" : "have"} a farther neighbour.`;
}

const capital = (text) => text[0].toUpperCase() + text.slice(1);

/** A question about pictures that are nearer to the training images of the other slot; "" if none is. */
export function swapHtml(images) {
  const all = Object.entries(images);
  if (!all.length || !all.every(([, image]) => image.strays)) return "";
  const [[modality]] = all;
  const said =
    all.length > 1
      ? `Are these two swapped? The ${TERMS.vis.one} is nearer to the training ${TERMS.tac.many}, the ${TERMS.tac.one} to the ${TERMS.vis.many}.`
      : `Is this a ${TERMS[OTHER[modality]].one}? It is nearer to those than to the training ${TERMS[modality].many}.`;
  return `<p class="note swapped">${said} <button type="button" class="swap">${all.length > 1 ? "Swap them" : "Move it"}</button></p>`;
}

/** The panel; `set` has thumbnails and names of domains and classes, once loaded. */
export function familiarHtml({ images, of, yours }, set) {
  const rows = Object.entries(images).map(([modality, image]) => {
    const mark = image.guess ? "wrong" : "right";
    const meter =
      image.quantile === undefined
        ? ""
        : `<div class="meter" aria-hidden="true"><i class="${mark}" style="--at:${image.quantile}"></i></div>`;
    return `<div class="look" data-modality="${modality}"><h4><span class="sign ${modality}"></span>${capital(TERMS[modality].one)}</h4>
      <p class="${image.words === undefined ? "hint" : mark}">${escaped(sentence(modality, image, yours))}</p>${meter}
      <div class="nearest">${each(image.nearest, (one) => neighbour(one, modality, set))}</div></div>`;
  });
  return `<header><h3>Seen before?</h3><p class="hint">Nearest: ${escaped(of)}</p></header><div class="looked">${rows.join("")}</div>`;
}

function neighbour({ pair, cosine }, modality, { frames, sprite }) {
  const tile = frames ? pair + (modality === "tac" ? frames.pairs : 0) : pair;
  const label = frames ? frames.classes[frames.label[pair]] : "";
  const name = label === NO_CLASS ? "" : label;
  const where = frames ? frames.domains[frames.domain[pair]] : "";
  const picture = frames
    ? thumbnail(sprite, tile, SIDE, name ? `${TERMS[modality].one} of ${name}` : TERMS[modality].one)
    : "";
  return `<button type="button" data-pair="${pair}" title="Open this pair${where && ` of ${escaped(where)}`}">${picture}<small><b>${escaped(name || `pair ${pair}`)}</b> ${cosine.toFixed(2)}</small></button>`;
}
