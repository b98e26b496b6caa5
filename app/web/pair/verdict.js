/** The prediction of one pair in words: both, photo only, touch only. Text in, HTML out. */

import { imagesOf, OTHER } from "../shared/images.js";
import { classColour } from "../shared/palette.js";
import { escaped, percent } from "../shared/text.js";

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
    READINGS.find(([reading]) => reading === name)[1] = `${title} only`;
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

/**
 * Three cards. `answer`: the server's predictions; `familiar`: familiarity of the images, null until
 * it arrives; `truths`: the class of each image, if known.
 */
export function cards(answer, familiar, truths) {
  const given = imagesOf(answer.exact.readings);
  const shown = READINGS.map(([reading, title, sign]) => {
    const row = answer.exact.readings[reading];
    const absent = reading === "fused" ? "" : ' title="The other image is absent"';
    const head = `<h3${absent}><span class="sign ${sign}"></span>${title}</h3>`;
    if (!row)
      return `<article class="reading none" data-reading="${sign}">${head}<p class="hint">No ${TERMS[reading].one} here.</p></article>`;
    if (reading === "fused" && given.length < 2) {
      return `<article class="reading none" data-reading="${sign}">${head}<p class="hint">Add the ${TERMS[OTHER[given[0]]].one} to see both together.</p></article>`;
    }
    const strange = unlike(reading, given, familiar?.images);
    return `<article class="reading" data-reading="${sign}">${head}${called(answer.classes, row, strange, familiar)}${judged(best(answer.classes, row).label, usedBy(reading, given), truths, answer.classes)}</article>`;
  });
  return `<div class="readings">${shown.join("")}</div>`;
}

/** A prediction in words; its figure waits for the familiarity, which may make it a guess. */
export function called(classes, row, strange, familiar) {
  const { label, share } = best(classes, row);
  if (!familiar) return `<p class="said">${escaped(label)}</p>`;
  if (!strange.length) return `<p class="said">${escaped(label)} <b>${percent(share)}</b></p>`;
  const what = strange.length > 1 ? "Both images are" : `The ${TERMS[strange[0]].one} is`;
  return `<p class="said guess">${escaped(label)}?</p><p class="guessed"><b>This is a guess.</b> ${what} unlike anything it has seen.</p>`;
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
  const shown = READINGS.filter(
    ([reading]) => readings[reading] && !(reading === "fused" && readings.fused === undefined),
  );
  const several = shown.length > 2 ? shown : shown.filter(([reading]) => reading !== "fused");
  const winner = best(classes, readings.fused).label;
  const given = imagesOf(readings);
  const grey = new Set(several.map(([reading]) => reading).filter((reading) => unlike(reading, given, images).length));
  const head = several.map(
    ([reading, title, sign]) =>
      `<th scope="col"><span class="sign ${sign}"></span>${title}${grey.has(reading) ? " <small>(guess)</small>" : ""}</th>`,
  );
  const rows = classes.map((name, k) => {
    const cells = several.map(
      ([reading, , sign]) =>
        `<td data-reading="${reading}"${grey.has(reading) ? ' class="of-guess"' : ""}><span class="bar ${sign}" style="--share:${readings[reading][k]}"></span><span class="share">${percent(readings[reading][k], 1)}</span></td>`,
    );
    return `<tr class="${name === winner ? "best" : ""}"><th scope="row"><i style="background:${classColour(k)}"></i>${escaped(name)}</th>${cells.join("")}</tr>`;
  });
  return `<table class="bar-table"><thead><tr><th scope="col">Class</th>${head.join("")}</tr></thead><tbody>${rows.join("")}</tbody></table>${grey.size ? '<p class="hint">Grey: figures for a guess. They were calibrated on images like the training images, so they mean little here.</p>' : ""}`;
}

/** The prediction in one sentence, for a screen reader. */
export function spoken(answer, familiar) {
  const { readings } = answer.exact;
  const given = imagesOf(readings);
  const { label, share } = best(answer.classes, readings.fused);
  return unlike("fused", given, familiar.images).length ? `${label}? This is a guess.` : `${label}, ${percent(share)}`;
}
