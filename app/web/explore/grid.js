/** Pictures of points: the neighbours of the pinned pair, and the pairs that are selected, found, or fooled. */

import { halvesOf, imitation, thumbnail, verdict } from "../shared/card.js";
import { classOf, domainOf, orderText } from "../shared/frames.js";
import { ofFrames } from "../shared/provenance.js";
import { sensorOf } from "../shared/tables.js";
import { $, html, joined, percent, put, scene, state } from "./root.js";
import { filtering, near, painted, strangePairs } from "./scene.js";
import { tagOf, tagPairs } from "./tags.js";

const SHOWN = 60; // pairs; the CSV holds all
const LESSON = 10; // in a chapter
const SIDE = 44; // CSS pixels of a picture

/** @typedef {{pairs: number[], points?: number, why?: string}} Listed */

/** Return the pairs to show, and why: those selected, else those that a filter leaves, else the look-alikes.
 * @returns {Listed} */
function listed() {
  const { frames, selected, mask, stop } = scene;
  const either = (/** @type {Wanted} */ wanted) =>
    Array.from(frames.label, (_, pair) => pair).filter((pair) => wanted(pair) || wanted(pair + frames.pairs));
  if (selected.size) return { points: selected.size, pairs: either((point) => selected.has(point)) };
  if (filtering(scene, state).length) return { pairs: either((point) => mask[point] === 1) };
  if (state.chapter !== "fooled") return { pairs: [] };
  const { strange, alike } = strangePairs(scene);
  if (alike.length) return { why: "pairs look like another class", pairs: alike };
  const wrong = strange.filter((pair) => frames.prediction[stop * frames.pairs + pair] !== frames.label[pair]);
  return { why: "unseen pairs are predicted wrong", pairs: wrong };
}

/** Return the heading of the listed pairs: how many are right, and their domains and classes. @param {Listed} listed */
function heading({ points, why, pairs }) {
  const { frames, stop } = scene;
  if (why) return html`<h4>${pairs.length} ${why}</h4>`;
  const read = painted(scene, state);
  const verdicts = pairs.map((pair) => verdict(read, pair, stop));
  const tally = (/** @type {"domain" | "truth"} */ key) =>
    Object.entries(Object.groupBy(verdicts, (v) => v[key]))
      .map(([name, of]) => ({ name, count: of?.length ?? 0 }))
      .sort((a, b) => b.count - a.count)
      .map(({ name, count }) => `${key === "domain" ? sensorOf(name) : name} ${count}`)
      .join(" · ");
  const judged = !frames.headless && frames.labelled;
  const share = percent(verdicts.filter(({ right }) => right).length / pairs.length);
  const home = verdicts.filter(({ domain }) => domain === frames.source).length;
  const right = judged && `; ${share} predicted right at p = ${orderText(frames.orders[stop])}`;
  return html`<h4>${points ? `${points} points selected` : `${pairs.length} pairs found`}</h4>
    <p class="hint">${pairs.length} pairs${right}.<br><b>Domains</b> ${tally("domain")}<br>
    <b>Classes</b> ${tally("truth")}</p>
    ${judged && ofFrames(frames, stop, `these pairs, ${home} of them of its source`)}`;
}

/** Return a verdict with its mark. @param {boolean} right @param {string} said */
export const marked = (right, said) => `${right ? "✓" : "✗"}\u00a0${said}`;

/** Return a button of a pair. @param {number} pair */
function tile(pair) {
  const { frames, sprite, stop, facts } = scene;
  const { truth, domain, said, right } = verdict(painted(scene, state), pair, stop);
  const note = imitation(facts.pairs, pair);
  const tag = tagOf(frames, pair);
  const predicted = said && `predicted ${said}`;
  const name = joined([`Pair ${pair}`, truth, note, sensorOf(domain), predicted, tag && `tag ${tag}`]);
  const words = said
    ? html`${!right && `${truth} `}<span class="${right ? "right" : "wrong"}">${marked(right, said)}</span>`
    : truth;
  return html`<button data-pair="${pair}" title="${name}" aria-label="${name}"><span class="thumbs">
    ${halvesOf(frames).map((half, i) => thumbnail(sprite, pair + i * frames.pairs, SIDE, half))}</span><small>${words}
    ${tag && html` <i class="tag">${tag}</i>`}</small></button>`;
}

/** Show the pictures. */
export function showGrid() {
  const box = $(".pictures");
  const list = listed();
  const { pairs, points, why } = list;
  box.parentElement.hidden = !pairs.length || !["fooled", "analyse"].includes(state.chapter);
  if (!pairs.length) return put(box, html``);
  const first = why ? LESSON : SHOWN;
  const tools = html`<div class="row">${points && html`<button class="clear">Clear</button>`}
    <button class="csv" data-save="csv">Save as CSV</button><label>Tag <input type="text" class="tagging"
    maxlength="40" placeholder="a word, then Enter"></label></div>`;
  const tiles = html`<div class="tiles">${pairs.slice(0, first).map(tile)}</div>
    ${pairs.length > first && html`<p class="hint">The CSV file has ${pairs.length - first} more pairs.</p>`}`;
  put(box, html`${heading(list)}${why ? [tiles, tools] : [tools, tiles]}`); // a chapter shows the pictures first
}

/** Tag the listed pairs with a word. @param {string} tag */
export function tagListed(tag) {
  tagPairs(scene.frames, listed().pairs, tag);
  showGrid();
}

/** Show the neighbours of the pinned pair as pictures, if they are of this step and p. */
export function showNeighbours() {
  const points = near(scene, state);
  const box = $(".card .found");
  if (box && points.length) put(box, neighboursHtml(points, scene));
}

/** @param {Nearest["points"]} points @param {Pick<Scene, "frames" | "sprite">} scene */
export const neighboursHtml = (points, { frames, sprite }) =>
  html`${points.map(({ point, cosine }) => {
    const half = halvesOf(frames)[Number(point >= frames.pairs)];
    const pair = point % frames.pairs;
    const where = `${classOf(frames, pair)}, ${sensorOf(domainOf(frames, pair))}`;
    const name = `${half} of pair ${pair}, ${where}, cosine ${cosine.toFixed(3)}`;
    return html`<button data-point="${point}" title="${name}" aria-label="${name}">
      ${thumbnail(sprite, point, 48, half)}<small>${half} ${cosine.toFixed(2)}</small></button>`;
  })}`;
