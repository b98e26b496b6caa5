/** Pictures of the pairs that are selected, found, or fooled, with a summary and their tags. */

import { imitation, thumbnail, verdict } from "../shared/card.js";
import { orderText } from "../shared/frames.js";
import { ofFrames } from "../shared/provenance.js";
import { state } from "../shared/store.js";
import { escaped, percent } from "../shared/text.js";
import { onClick } from "../shared/view.js";
import { tagOf, tagPairs } from "./tags.js";

const SHOWN = 60; // pairs; the CSV holds all
const LESSON = 10; // in a chapter
const SIDE = 44; // CSS pixels of a picture

/** The pairs to show, and why: those selected, else those that a filter leaves, else the look-alikes.
 * @returns {{pairs: number[], points?: number, why?: string}} */
export function listed(scene) {
  const { frames, selected, facts } = scene;
  const all = Array.from({ length: frames.pairs }, (_, pair) => pair);
  if (selected.size)
    return { points: selected.size, pairs: all.filter((p) => selected.has(p) || selected.has(p + frames.pairs)) };
  if (scene.filtering().length) return { pairs: all.filter((p) => scene.shown(p) || scene.shown(p + frames.pairs)) };
  if (state.chapter !== "fooled" || !facts.pairs || !facts.unseen) return { pairs: [] };
  const strange = (p) => facts.unseen.pairs.counts[p] && frames.domains[frames.domain[p]] !== facts.unseen.source;
  const alike = all.filter((p) => facts.pairs.looks_like[p] && strange(p));
  const wrong = (p) => frames.prediction[scene.stop * frames.pairs + p] !== frames.label[p];
  return alike.length
    ? { why: "look like another class", pairs: alike }
    : { why: "unseen pairs predicted wrong", pairs: all.filter((p) => strange(p) && wrong(p)) };
}

/** @param {{pairs: number[], points?: number, why?: string}} what */
function heading({ points, why, pairs }, scene) {
  const { frames, stop } = scene;
  const verdicts = pairs.map((pair) => verdict(frames, pair, stop));
  const right = verdicts.filter((v) => v.right).length;
  const tally = (key) =>
    Object.entries(/** @type {Record<string, any[]>} */ (Object.groupBy(verdicts, (v) => v[key])))
      .sort((a, b) => b[1].length - a[1].length)
      .map(([name, own]) => `${escaped(name)} ${own.length}`)
      .join(" · ");
  if (why) return `<h4>${pairs.length} ${why}</h4>`;
  const judged = !frames.headless && frames.labelled;
  const score = judged
    ? `; ${percent(right / pairs.length)} predicted right at p = ${orderText(frames.orders[stop])}`
    : "";
  const home = pairs.filter((pair) => frames.domains[frames.domain[pair]] === frames.source).length;
  const whence = judged ? ofFrames(frames, stop, `these pairs, ${home} of them of its source`) : "";
  return `<h4>${points ? `${points} points selected` : `${pairs.length} pairs found`}</h4>
    <p class="hint">${pairs.length} pairs${score}.<br><b>Domains</b> ${tally("domain")}<br><b>Classes</b> ${tally("truth")}</p>${whence}`;
}

function tile(pair, scene) {
  const { frames, sprite, stop, facts } = scene;
  const v = verdict(frames, pair, stop);
  const note = imitation(facts.pairs, pair);
  const tag = tagOf(frames, pair);
  const said = v.said
    ? `${v.right ? "" : `${escaped(v.truth)} `}<span class="${v.right ? "right" : "wrong"}">${v.right ? "✓" : "✗"}\u00a0${escaped(v.said)}</span>`
    : escaped(v.truth);
  const name = `Pair ${pair}, ${v.truth}${note && `, ${note}`}, ${v.domain}, ${v.said && `predicted ${v.said}`}${tag && `, tag ${tag}`}`;
  const pictures = [pair, pair + frames.pairs].map((t, i) => thumbnail(sprite, t, SIDE, ["VIS", "TAC"][i]));
  return `<button type="button" data-pair="${pair}" title="${escaped(name)}" aria-label="${escaped(name)}"><span class="thumbs">${pictures.join("")}</span><small>${said}${tag && ` <i class="tag">${escaped(tag)}</i>`}</small></button>`;
}

/** `on`: onPick(pair), onClear(), onSave(). */
export function showGrid(box, scene, { onPick, onClear, onSave }) {
  const what = listed(scene);
  const { pairs, points } = what;
  box.parentElement.hidden = !pairs.length || !["fooled", "analyse"].includes(state.chapter);
  if (!pairs.length) {
    box.innerHTML = "";
    return;
  }
  const row = `<div class="row">${points ? '<button type="button" class="clear">Clear</button>' : ""}<button type="button" class="csv">Save as CSV</button><label>Tag <input type="text" class="tagging" maxlength="40" placeholder="a word, then Enter"></label></div>`;
  const first = what.why ? LESSON : SHOWN;
  const tiles = pairs.slice(0, first).map((pair) => tile(pair, scene));
  const more = pairs.length > first ? `<p class="hint">${pairs.length - first} more pairs are in the CSV.</p>` : "";
  const parts = [`<div class="tiles">${tiles.join("")}</div>${more}`, row];
  box.innerHTML = heading(what, scene) + (what.why ? parts : parts.reverse()).join(""); // a chapter shows the pictures first
  onClick(box, { ".csv": onSave, ".clear": onClear, "[data-pair]": ({ dataset }) => onPick(+dataset.pair) });
  box.querySelector(".tagging").onchange = (event) => {
    tagPairs(scene.frames, pairs, event.target.value.trim());
    showGrid(box, scene, { onPick, onClear, onSave });
  };
}
