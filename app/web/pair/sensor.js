/** My sensor, loaded when it is opened: its card from touches without labels, what changed against another folder, and
 * what mends it. */

import {
  button,
  capital,
  chooser,
  headed,
  hint,
  html,
  kinds,
  MENDS,
  madeOf,
  percent,
  plural,
  pressed,
  row,
  status,
  TERMS,
  table,
  titleOf,
} from "./parts.js";
import { brief, readingsIn, readingsOf } from "./verdict.js";

/** @typedef {Replies["card"]} Cards @typedef {Cards["cards"][number]} Card */
/** The two folders, the new one first. @type {[side: "now" | "before", title: string][]} */
const SIDES = [
  ["now", "My sensor"],
  ["before", "Compare with"],
];
const COLOURS = ["red", "green", "blue"];
const MOST_DOTS = 14; // along a side of the drawing
const PROFILE = "Use a profile of these pictures";
/** What has a bar: its name, its value in a card, its place in a gel's numbers and its unit.
 * @type {[string, (card: Card) => number, number, string][]} */
const BARS = [
  ["Grain", ({ noise }) => noise, 0, " of 255"],
  ["Sharpness", ({ sharpness }) => Math.exp(sharpness ?? Number.NaN), 1, ""],
];

/** The panel. @param {PairTab} tab */
export function sensorHtml(tab) {
  const { counts, doing, doubt, notes, before, answer, folders, card } = tab;
  const use = counts
    ? [button("saveProfile", "Save"), button("profileDropped", "Stop using it")]
    : chooser("load", "Load profile", html`accept=".safetensors"`);
  const question =
    doubt &&
    html`${doubt.strange} of ${doubt.of} pictures look more like ${TERMS.vis.many} than like ${TERMS.tac.many}. What
      are they? ${kinds("sampled")}`;
  const progress =
    doing.sample &&
    html`Reading picture ${doing.sample.done} of ${doing.sample.total}… ${button("samplingStopped", "Cancel")}`;
  const words = counts
    ? `The profile of ${madeOf(counts)} is in use. Label some pairs to check it.`
    : html`Give 10 to 50 unlabelled pictures of one sensor: the card shows what it is like. With a second folder, it
        shows what changed.`;
  const offered = folders.now.length > 0 && !card?.changes?.some(({ profile }) => profile);
  return html`${hint(words)}
    <div class="sides">${SIDES.map(([side, title], i) => sideHtml(side, title, folders[side], card?.cards[i]))}</div>
    ${status(doing.card ?? notes.card)}${card && [barsHtml(card), changesHtml(card, tab)]}
    <div class="row">${offered && button("sampled", PROFILE)}${use}</div>
    ${status(progress ?? question ?? notes.sensor)}${before && answer && comparedHtml(before, answer)}`;
}

/** One folder: where it is chosen, and what its touches show. @param {string} side @param {string} title
 * @param {Chosen[]} files @param {Card} [card] */
function sideHtml(side, title, files, card) {
  const choose = (/** @type {string} */ what, kind = "") =>
    chooser("carded", what, html`${kind}multiple data-side="${side}" aria-label="${what}: ${title}"`);
  return html`<div class="folder-side" data-drop="carded" data-side="${side}">${headed(title)}
    <div class="row">${choose("Pictures")}${choose("Folder", "webkitdirectory ")}</div>
    ${card ? drawnHtml(card) : hint(files.length ? plural(files.length, "file") : "Drop touches here.")}</div>`;
}

/** The gel's light, its lamps and its dots, drawn and in words. @param {Card} card */
function drawnHtml({ background, lamps, no_lamps, halves, dots, pitch, pictures, size, missing }) {
  const few = dots < 0.5 && `, ${dots ? percent(dots) : "none"} with printed dots`;
  const sure = halves === null ? "" : ` The lamps of both halves agree at ${halves.toFixed(2)}.`;
  return html`<div class="drawn"><img src="${background}" alt="Light of the gel without relief">
    ${lamps && roseHtml(lamps)}${pitch && dots >= 0.5 && dotsHtml(dots, pitch)}</div>
    ${hint(html`${plural(pictures, "picture")} of ${size.join(" × ")} pixels${few}.${lamps ? sure : ` ${no_lamps}`}
      ${` ${missing}`}`)}`;
}

/** From where each colour lights the gel: as far from the middle as it is strong. @param {number[][]} lamps */
export function roseHtml(lamps) {
  const longest = Math.max(...lamps.map((lamp) => Math.hypot(...lamp)));
  const words = lamps.map(([x, y], c) => {
    const from = ((Math.atan2(y, -x) * 180) / Math.PI + 360) % 360;
    return `${COLOURS[c]} from ${from.toFixed(0)}°`;
  });
  const rays = lamps.map(([x, y], c) => {
    const [right, down] = [-x, -y].map((length) => ((34 * length) / longest).toFixed(1));
    const [textX, textY] = [+right * 1.2, +down * 1.2 + 4];
    return html`<line x2="${right}" y2="${down}" class="${COLOURS[c]}"/><text x="${textX}" y="${textY}">
      ${COLOURS[c][0].toUpperCase()}</text>`;
  });
  return html`<svg class="rose" viewBox="-50 -50 100 100" role="img" aria-label="Lamps: ${words.join(", ")}; 0° is the
    right, 90° the top"><circle r="34"/>${rays}</svg>`;
}

/** The grid of printed dots. @param {number} share @param {number} pitch */
function dotsHtml(share, pitch) {
  const side = Math.min(MOST_DOTS, Math.max(2, Math.round(1 / pitch)));
  const place = (/** @type {number} */ k) => ((100 * (k + 0.5)) / side - 50).toFixed(1);
  const all = Array.from({ length: side * side }, (_, k) => k);
  return html`<svg class="dots" viewBox="-50 -50 100 100" role="img" aria-label="Printed dots in ${percent(share)} of
    the pictures, ${percent(pitch)} of the picture apart">
    ${all.map((k) => html`<circle r="2" cx="${place(k % side)}" cy="${place(Math.floor(k / side))}"/>`)}</svg>`;
}

/** Grain and sharpness as bars, with a mark for each simulated gel. @param {Cards} card */
function barsHtml({ cards, gels }) {
  const rows = BARS.map(([name, read, at, unit]) => {
    const marks = Object.entries(gels).map(([gel, numbers]) => /** @type {const} */ ([gel, numbers[at]]));
    const values = cards.map(read);
    const most = 1.1 * Math.max(...values.filter(Number.isFinite), ...marks.map(([, value]) => value));
    const share = (/** @type {number} */ value) => (value / most || 0).toFixed(3);
    const bars = values.map(
      (value, k) =>
        html`<span class="gauge"><i class="bar ${k && "vis"}" style="--share:${share(value)}"></i>
          ${marks.map(([gel, mark]) => html`<u title="${gel}" style="--at:${share(mark)}"></u>`)}</span>
          <small>${value.toFixed(at + 1)}${unit}</small>`,
    );
    return row(name, [html`${bars}`]);
  });
  return html`<table class="gauges" aria-label="Beside simulated gels">${rows}</table>
    ${hint(`Each mark is a simulated gel.${cards.length > 1 ? " The second bar is the other folder." : ""}`)}`;
}

/** What changed, the likeliest first, and what mends it. @param {Cards} card @param {PairTab} tab */
function changesHtml({ changes }, { mend, counts }) {
  if (!changes) return null;
  if (!changes.length) return hint("Nothing changed that these pictures show.");
  const first = changes.findIndex(({ profile }) => profile); // whose button stands for all
  return html`<ol class="changes">${changes.map(({ part, evidence, cost, remedy, mend: word, profile }, i) => {
    const words = word
      ? button(
          "mended",
          capital(`read touches ${MENDS[word]}`),
          html`data-word="${word}" ${pressed(mend.split(" ").includes(word))}`,
        )
      : profile
        ? i === first
          ? button("sampled", PROFILE, html`data-kind="tac" ${pressed(counts)}`)
          : "The same profile undoes a part of it."
        : remedy;
    return html`<li><b>${capital(part)}.</b> ${evidence} ${cost && html`<small>${cost}</small>`} <div
      class="row">${words}</div></li>`;
  })}</ol>`;
}

/** Each reading of a pair before and after; guesses have no figure. @param {NonNullable<PairTab["before"]>} before
 * @param {Predicted} after */
function comparedHtml(before, after) {
  const then = readingsIn(after);
  const rows = readingsOf(before).map(
    (said, i) => said.label && row(titleOf(said.reading), [brief(said), brief(then[i])]),
  );
  return table("This pair as it comes and mended", ["This pair", "as it comes", "mended"], rows.filter(Boolean));
}
