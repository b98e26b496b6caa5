/** The card of one pair: thumbnails, class and prediction. */

import { has } from "./tables.js";
import { escaped } from "./text.js";

/** A thumbnail from the sheet: VIS of pair i is tile i, TAC is tile N + i. */
export function thumbnail(sprite, tile, side, words) {
  const label = escaped(words);
  if (!sprite) return `<span class="thumb none" role="img" aria-label="${label}">${label}</span>`;
  const scale = side / sprite.tile;
  const column = tile % sprite.columns;
  const row = Math.floor(tile / sprite.columns);
  const rows = Math.ceil(sprite.count / sprite.columns);
  return `<span class="thumb" role="img" aria-label="${label}" style="width:${side}px;height:${side}px;
    background-image:url('${sprite.url}');background-position:${-column * side}px ${-row * side}px;
    background-size:${sprite.columns * sprite.tile * scale}px ${rows * sprite.tile * scale}px"></span>`;
}

export const thumbnailPair = (frames, sprite, pair, side) =>
  `<span class="thumbs"><figure>${thumbnail(sprite, pair, side, "VIS")}<figcaption>VIS</figcaption></figure>
   <figure>${thumbnail(sprite, frames.pairs + pair, side, "TAC")}<figcaption>TAC</figcaption></figure></span>`;

/** The prediction for a pair at one stop. */
export function verdict(frames, pair, stop) {
  const at = stop * frames.pairs + pair;
  const said = frames.answered?.[pair] ?? frames.prediction[at];
  return {
    domain: frames.domains[frames.domain[pair]],
    truth: frames.classes[frames.label[pair]],
    said: frames.headless ? "" : frames.classes[said],
    right: !frames.headless && said === frames.label[pair],
    confidence: has(frames, "confidence") && !frames.answered ? frames.confidence[at] / 255 : NaN, // other heads have no temperature
  };
}

/** A verdict in words: its class, and its probability if that has a temperature; no mark without a true class. */
const saidHtml = ({ right, said, confidence }, labelled = true) =>
  `${labelled ? (right ? "✓ " : "✗ ") : ""}${escaped(said)}${Number.isFinite(confidence) ? `, ${Math.round(100 * confidence)} %` : ""}`;

/** The class that a pair imitates, in words; "" if none. */
export function imitation(pairs, pair) {
  const [looks, feels] = ["looks_like", "feels_like"].map((column) => pairs?.[column][pair]);
  if (looks) return `looks like ${looks}: only touch can tell`;
  return feels ? `feels like ${feels}` : "";
}

/** `sample` is shown until a visitor points at a pair; -1 for none. `pairs` has the names, once loaded. */
export function card(frames, sprite, pair, stop, pinned, sample = -1, pairs = null) {
  if (pair < 0) {
    const example = sample < 0 || !sprite ? "" : thumbnailPair(frames, sprite, sample, 124);
    const names = sample < 0 || frames.labelled === false ? "" : `: ${escaped(frames.classes[frames.label[sample]])}`;
    const [title, points] = frames.signals
      ? ["Two recordings of one signal", "● one recording, ▲ the other"]
      : ["A photo and a touch", "● photo, ▲ touch"];
    return `<h3>${title}${names}</h3>${example}<p class="hint">${points}. <span class="keys" title="Keys: N and B step through pairs, Enter pins"><b>Point</b> at one, <b>click</b> to pin.</span></p>`;
  }
  const v = verdict(frames, pair, stop);
  const note = imitation(pairs, pair);
  const source = v.domain === frames.source ? ' <small class="source">source</small>' : "";
  return `<h3>Pair ${pair}${pinned ? ' <span class="tag">pinned</span>' : ""}</h3>
    ${sprite ? thumbnailPair(frames, sprite, pair, 124) : ""}
    <dl><dt>Domain</dt><dd>${escaped(v.domain)}${source}</dd><dt>Class</dt><dd>${frames.labelled === false ? "–" : escaped(v.truth)}${note ? ` <small>${escaped(note)}</small>` : ""}</dd>
    ${v.said && `<dt>Predicted</dt><dd class="${frames.labelled !== false ? (v.right ? "right" : "wrong") : ""}">${saidHtml(v, frames.labelled)}</dd>`}</dl>
    ${
      pinned
        ? `<div class="near"><h4>Nearest by cosine${has(frames, "heads") ? ", raw embedding," : ""} to <span><button type="button" class="find" data-of="0">VIS</button> <button type="button" class="find" data-of="1">TAC</button></span></h4><div class="found"></div></div>
    <div class="row">${frames.headless ? "" : '<button type="button" class="open">Open in Pair ›</button>'}<button type="button" class="unpin">Unpin</button></div>`
        : ""
    }`;
}
