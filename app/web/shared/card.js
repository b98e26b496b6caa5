/** The card of one pair: thumbnails, class and prediction. */

import { classOf, domainOf } from "./frames.js";
import { saidOf } from "./palette.js";
import { has, sensorOf } from "./tables.js";
import { html, joined } from "./text.js";

/** Return a thumbnail from the sheet: VIS of pair i is tile i, TAC is tile N + i.
 * @param {Sprite | null} sprite @param {number} tile @param {number} side @param {string} words */
export function thumbnail(sprite, tile, side, words) {
  if (!sprite) return html`<span class="thumb none" role="img" aria-label="${words}">${words}</span>`;
  const { url, columns, count } = sprite;
  const [left, top] = [tile % columns, Math.floor(tile / columns)].map((steps) => -steps * side);
  return html`<span class="thumb" role="img" aria-label="${words}" style="width:${side}px;height:${side}px;
    background-image:url('${url}');background-position:${left}px ${top}px;
    background-size:${columns * side}px ${Math.ceil(count / columns) * side}px"></span>`;
}

/** What the two halves of a pair are called. @param {{signals?: unknown}} frames */
export const halvesOf = ({ signals }) => (signals ? ["one", "the other"] : ["photo", "touch"]);

/** @param {Frames} frames @param {Sprite | null} sprite @param {number} pair @param {number} side */
export const thumbnailPair = (frames, sprite, pair, side) =>
  html`<span class="thumbs">${halvesOf(frames).map(
    (name, i) =>
      html`<figure>${thumbnail(sprite, pair + i * frames.pairs, side, name)}<figcaption>${name}</figcaption></figure>`,
  )}</span>`;

/** Return the prediction for a pair at one stop. @param {Frames} frames @param {number} pair @param {number} stop */
export function verdict(frames, pair, stop) {
  const said = saidOf(frames, pair, stop);
  return {
    domain: domainOf(frames, pair),
    truth: classOf(frames, pair),
    said: frames.headless ? "" : frames.classes[said],
    right: !frames.headless && said === frames.label[pair],
    // other heads have no temperature
    confidence:
      has(frames, "confidence") && !frames.answered ? frames.confidence[stop * frames.pairs + pair] / 255 : NaN,
  };
}

/** Return the pair in a sentence, for a screen reader.
 * @param {Frames} frames @param {number} pair @param {number} stop
 * @param {boolean} pinned */
export function spoken(frames, pair, stop, pinned) {
  const { domain, truth, said, right } = verdict(frames, pair, stop);
  const predicted = said && `predicted as ${said}${frames.labelled ? (right ? ", correct" : ", wrong") : ""}`;
  return joined([`Pair ${pair}`, pinned && "pinned", frames.labelled && truth, sensorOf(domain), predicted]);
}

/** Return the class that a pair imitates, in words; "" if none. @param {PairNames | null} pairs @param {number} pair */
export function imitation(pairs, pair) {
  const [looks, feels] = [pairs?.looks_like[pair], pairs?.feels_like[pair]];
  if (looks) return `looks like ${looks}`;
  return feels ? `feels like ${feels}` : "";
}

/** Return the card of a pair; `pairs` has the names, once loaded. Without a pair, -1, the card shows the pair `sample`,
 * if any.
 * @param {Frames} frames @param {Sprite | null} sprite @param {number} pair @param {number} stop
 * @param {boolean} pinned
 * @param {PairNames | null} pairs */
export function card(frames, sprite, pair, stop, pinned, sample = -1, pairs = null) {
  const { labelled, headless } = frames;
  /** @param {number} pair */
  const pictures = (pair) => sprite && pair >= 0 && thumbnailPair(frames, sprite, pair, 124);
  if (pair < 0) {
    const name = sample >= 0 && labelled && `: ${classOf(frames, sample)}`;
    const [title, points] = frames.signals
      ? ["Two recordings of one signal", "● one recording, ▲ the other"]
      : ["A photo and a touch", "● photo, ▲ touch"];
    return html`<h3>${title}${name}</h3>${pictures(sample)}<p class="hint">${points}. <span class="keys"
      title="Keys: N and B step through pairs, Enter pins"><b>Point</b> at one, <b>click</b> to pin.</span></p>`;
  }
  const { domain, truth, said, right, confidence } = verdict(frames, pair, stop);
  const note = imitation(pairs, pair);
  const sure = Number.isFinite(confidence) && `, ${Math.round(100 * confidence)} %`;
  const predicted = html`<dt>Predicted</dt><dd class="${labelled && (right ? "right" : "wrong")}">
    ${labelled && (right ? "✓ " : "✗ ")}${said}${sure}</dd>`;
  const more = html`<div class="near"><h4>Nearest by cosine${frames.foreign && " of raw embeddings"} to <span>
    ${halvesOf(frames).map((name, i) => html`<button class="find" data-of="${i}">${name}</button> `)}</span></h4>
    <div class="found"></div></div>
    <div class="row">${!headless && html`<button class="open">Open in Try a pair ›</button>`}
      <button class="unpin">Unpin</button></div>`;
  return html`<h3>Pair ${pair}${pinned && html` <span class="tag">pinned</span>`}</h3>
    ${pictures(pair)}
    <dl><dt>Domain</dt><dd>${sensorOf(domain)}
      ${domain === frames.source && html` <small class="source">source</small>`}</dd><dt>Class</dt>
      <dd>${labelled ? truth : "–"}${note && html` <small>${note}</small>`}</dd>
    ${said && predicted}</dl>
    ${pinned && more}`;
}
