/** Unseen domains: look-alikes and each reading of them, every domain, confusion. */

import { thumbnail } from "../shared/card.js";
import { ofFrames, unseenPairs } from "../shared/provenance.js";
import { radios } from "../shared/radios.js";
import { change, state } from "../shared/store.js";
import { each, escaped, options, percent } from "../shared/text.js";
import { onClick } from "../shared/view.js";

export const READINGS = [
  { key: "vis", label: "Photo", title: "The touch is absent" },
  { key: "tac", label: "Touch", title: "The photo is absent" },
  { key: "fused", label: "Both" },
];
export const UNSEEN = "unseen";
const NUMBERS = "no one two three four five six seven eight nine ten eleven twelve".split(" ");
export const inWords = (n) => NUMBERS[n] ?? String(n);
const NO_CELL = "Choose a cell to see its pairs.";
const SHOWN = 3; // look-alikes with both pictures, at most
const ROOM = 165; // CSS pixels for one of them
const times = (counts) => counts.flat().reduce((a, b) => Math.max(a, b), 1);

const whisker = (own) =>
  own
    ? `<i class="range" style="--low:${own.low};--high:${own.high}"></i><i class="mean" style="--share:${own.share}"></i>`
    : "";

/** Look-alikes of unseen domains, the first of each class. */
export function lookAlikes({ frames, facts: { pairs, unseen } }, most = SHOWN) {
  const source = frames.domains.indexOf(unseen.source);
  const found = new Map();
  for (let pair = 0; pair < frames.pairs; pair++)
    if (unseen.pairs.counts[pair] && frames.domain[pair] !== source && pairs.looks_like[pair])
      if (!found.has(frames.label[pair])) found.set(frames.label[pair], pair);
  return [...found.values()].slice(0, most);
}

export class Strangers {
  /** `onCell(cell)` filters the map: {domain, truth, answer} or null; `onPick(pair)` pins a pair. */
  constructor($, scene, { onCell, onPick }) {
    this.box = $(".strangers");
    this.confused = $(".confused");
    this.domains = $(".each-domain");
    this.scene = scene;
    this.onCell = onCell;
    this.onPick = onPick;
    /** @type {(() => void) | null} */
    this.marked = null;
    this.domain = UNSEEN;
    /** @type {any} */
    this.cell = null;
  }

  /** Show the facts about the head. */
  show() {
    const facts = this.scene.facts.unseen;
    if (!facts) return;
    const measured = facts.domains.some((one) => one["answers/fused"]); // else there are no test pairs
    for (const part of [this.box, this.confused.parentElement, this.domains.parentElement])
      part.classList.toggle("nothing", !measured);
    if (!this.marked) {
      this.box.innerHTML =
        '<div class="lookers"></div><div class="readings bars" role="radiogroup" aria-label="What the head is given"></div>';
      this.confused.innerHTML = `<p>Columns: predicted, of <select class="of-domain" aria-label="Domain of the confusion matrix"></select></p><div class="confusion"></div>
        <p class="hint cell-words">${NO_CELL}</p>`;
      this.marked = radios(
        this.box.querySelector(".readings"),
        READINGS,
        () => state.reading,
        (reading) => change({ reading }),
      );
    }
    this.marked();
    this.showLookers();
    this.showReadings(facts);
    this.domains.innerHTML = this.bars(facts);
    this.listDomains(facts);
    this.showConfusion();
  }

  /** Both pictures of a few look-alikes, and what the head reads in each alone. */
  showLookers() {
    const { scene } = this;
    const { frames, sprite, facts } = scene;
    const { classes, pairs } = facts.unseen;
    const box = this.box.querySelector(".lookers");
    box.hidden = !facts.unseen.look_alikes || !facts.pairs || !sprite;
    if (box.hidden) return;
    const shown = Math.max(1, Math.min(SHOWN, Math.floor(this.box.clientWidth / ROOM)));
    const side = Math.min(110, Math.floor(this.box.clientWidth / shown / 2) - 22);
    box.style.gridTemplateColumns = `repeat(${shown}, minmax(0, 1fr))`;
    const read = (pair, reading, label) => {
      const said = pairs.answers[reading][pair];
      const right = said === frames.label[pair];
      const tile = reading === "tac" ? frames.pairs + pair : pair;
      return `<figure>${thumbnail(sprite, tile, side, label)}<figcaption class="${right ? "right" : "wrong"}">${right ? "✓" : "✗"}\u00a0${escaped(classes[said])}</figcaption></figure>`;
    };
    box.innerHTML = each(
      lookAlikes(scene, shown),
      (pair) =>
        `<button type="button" data-pair="${pair}"><span class="thumbs">${read(pair, "vis", "photo")}${read(pair, "tac", "touch")}</span>${escaped(classes[frames.label[pair]])}, like ${escaped(facts.pairs.looks_like[pair])}</button>`,
    );
    onClick(box, { "[data-pair]": ({ dataset }) => this.onPick(+dataset.pair) });
  }

  /** A bar for each reading: of the look-alikes, or of all unseen pairs where there are none. */
  showReadings(facts) {
    const of = facts.look_alikes ?? facts.unseen;
    for (const button of this.box.querySelectorAll(".readings button")) {
      const own = of[`answers/${button.dataset.key}`];
      const label = READINGS.find(({ key }) => key === button.dataset.key)?.label;
      const figure = own
        ? `<b>${percent(own.share)}</b> <small>${(100 * own.low).toFixed(0)}–${(100 * own.high).toFixed(0)}</small>`
        : "–";
      button.innerHTML = `<span>${label}</span><span class="scale" style="--chance:${facts.chance}">${whisker(own)}</span><output>${figure}</output>`;
    }
  }

  /** Every domain, by the chosen reading. */
  bars(facts) {
    const key = `answers/${state.reading}`;
    const row = (name, own, kind, note, title = "") =>
      `<div class="bar-row ${kind}" data-domain="${escaped(name)}" title="${title}"><span class="who">${escaped(name.replace(/-sim$/, ""))}${kind === "source" ? ' <b class="tag source">source</b>' : ""}</span><span class="scale" style="--chance:${facts.chance}">${whisker(own)}</span><output>${own ? percent(own.share) : "–"}</output>${note}</div>`;
    const measured = facts.domains.filter((one) => one.pairs || one[key]);
    const domains = measured.map((one) =>
      row(one.name, one[key], one.is_source ? "source" : "", `<span class="sr">${one.pairs} test pairs</span>`),
    );
    const retrieval =
      "How often the touch nearest to a photo in the same domain has its class; each image is seen alone, at F̂";
    return `${domains.join("")}<hr>${row("unseen, mean", facts.unseen[key], "mean-row", "")}${row("retrieval", facts.unseen.retrieval, "", "", retrieval)}${ofFrames(this.scene.own, this.scene.own.stop(this.scene.own.learned), `its test pairs, ${unseenPairs(this.scene.own, facts)}`)}`;
  }

  listDomains(facts) {
    const select = this.confused.querySelector(".of-domain");
    const names = [
      [UNSEEN, "all strangers"],
      ...facts.domains.map(({ name, is_source }) => [name, is_source ? `${name} (source)` : name]),
    ];
    select.innerHTML = options(names, this.domain);
    select.onchange = () => {
      this.domain = select.value;
      this.choose(null);
      this.showConfusion();
    };
  }

  showConfusion() {
    const facts = this.scene.facts.unseen;
    const counts = facts.confusion[state.reading][this.domain];
    const most = times(counts);
    const head = facts.classes.map((name) => `<th scope="col" title="${escaped(name)}">${escaped(name)}</th>`);
    const rows = counts.map(
      (row, truth) =>
        `<tr><th scope="row">${escaped(facts.classes[truth])}</th>${each(row, (n, answer) => this.button(n, n / most, truth, answer))}</tr>`,
    );
    const box = this.confused.querySelector(".confusion");
    box.innerHTML = `<table><thead><tr><th scope="col"><small>true ↓</small></th>${head.join("")}</tr></thead><tbody>${rows.join("")}</tbody></table>`;
    onClick(box, { "[data-truth]": ({ dataset }) => this.choose({ truth: +dataset.truth, answer: +dataset.answer }) });
  }

  button(count, strength, truth, answer) {
    const [is, said] = [truth, answer].map((k) => this.scene.facts.unseen.classes[k]);
    const on = this.cell?.truth === truth && this.cell?.answer === answer;
    return `<td class="${truth === answer ? "hit" : ""}"><button type="button" aria-pressed="${on}" data-truth="${truth}" data-answer="${answer}" style="--s:${(100 * strength).toFixed(0)}%" aria-label="${escaped(is)} predicted as ${escaped(said)}: ${count} pairs" ${count ? "" : "disabled"}>${count || ""}</button></td>`;
  }

  /** Filter the map by a cell; a second click, or null, shows all pairs. */
  choose(cell) {
    const again = cell && this.cell?.truth === cell.truth && this.cell?.answer === cell.answer;
    change({ cell: again || !cell ? "" : [cell.truth, cell.answer, this.domain].join("~") });
  }

  /** Show the cell in the address, if there is such a cell. */
  follow() {
    const [truth, answer, ...name] = state.cell.split("~");
    const domain = name.join("~");
    const { classes, confusion } = this.scene.facts.unseen;
    const known = Object.hasOwn(confusion[state.reading], domain) && classes[+truth] && classes[+answer];
    this.cell = known ? { truth: +truth, answer: +answer } : null;
    if (known) this.domain = this.confused.querySelector(".of-domain").value = domain;
    this.showConfusion();
    this.onCell(this.cell && { ...this.cell, domain: this.domain, pairs: this.pairsOf(this.cell) });
    this.confused.querySelector(".cell-words").textContent = this.cell
      ? "These pairs are on the map and in the table below, which shows what is predicted at the current p."
      : NO_CELL;
  }

  pairsOf({ truth, answer }) {
    const { frames, facts } = this.scene;
    const { counts, answers } = facts.unseen.pairs;
    const source = frames.domains.indexOf(facts.unseen.source);
    const domain = frames.domains.indexOf(this.domain);
    const found = [];
    for (let pair = 0; pair < frames.pairs; pair++) {
      const inDomain = this.domain === UNSEEN ? frames.domain[pair] !== source : frames.domain[pair] === domain;
      if (counts[pair] && inDomain && frames.label[pair] === truth && answers[state.reading][pair] === answer)
        found.push(pair);
    }
    return found;
  }
}
