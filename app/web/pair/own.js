/** The visitor's own pairs: labels, a running count, and teaching the head. */

import { ask, attempt, bytesOf, made, visit } from "../shared/api.js";
import { Scale } from "../shared/chart.js";
import { loaded } from "../shared/facts.js";
import { IMAGES } from "../shared/images.js";
import { provenance } from "../shared/provenance.js";
import { save } from "../shared/save.js";
import { escaped, percent, row, table } from "../shared/text.js";
import { onClick, View } from "../shared/view.js";
import { isOwn, keyOf, lessonsFor, missing, tally, withoutPair, withPair } from "./tally.js";
import { READINGS, said } from "./verdict.js";
import { zipped } from "./zip.js";

export class OwnPairs extends View {
  /** onAgain: predict again, by another head; onLabel: a label is new; onOpen: show this pair; onChange: whenever shown. */
  constructor(box, { onAgain, onLabel, onOpen, onChange }) {
    super(box);
    this.onChange = onChange;
    this.onAgain = onAgain;
    this.onLabel = onLabel;
    this.pairs = [];
    this.learned = "its own training pairs";
    loaded().then(
      ({ head }) => (this.learned = head.provenance?.source ?? this.learned),
      () => {}, // the page itself reports a lost set
    );
    this.report = null; // result of teaching
    this.labels = null; // what fewer labels of each class teach, once it is there
    this.counting = new AbortController(); // of these
    this.inUse = false;
    this.note = "";
    this.held = false; // while a picture is on its way, a label would go to the pair before it
    const named = ({ dataset }) => this.pairs.find((one) => keyOf(one) === dataset.key);
    onClick(box, {
      "[data-label]": ({ dataset }) => this.label(dataset.label),
      ".drop": ({ dataset }) => this.changed(withoutPair(this.pairs, dataset.key)),
      ".open": (button) => onOpen(named(button)),
      ".teach": () => this.teach(),
      ".use": () => {
        this.inUse = !this.inUse;
        this.show(this.now);
        onAgain();
      },
      ".save-set": () => this.keep("save/set", "my-pairs.zip"),
      ".save-pictures": () => this.keepPictures(),
      ".save-head": () => this.keep("save/head", "taught-head.zip"),
    });
    box.onsubmit = (event) => {
      event.preventDefault();
      this.label(box.querySelector("input[name=label]").value.trim());
    };
  }

  /** The lessons for a request about the pair `now`; none while the plain head is used. */
  lessons(now) {
    const lessons = this.inUse ? lessonsFor(this.pairs, now) : [];
    return lessons.length ? { lessons } : {};
  }

  /** What the head that reads own pictures learned from. */
  get source() {
    return visit.head ? "all simulated sensors" : this.learned;
  }

  labelOf(pair) {
    return this.pairs.find((one) => keyOf(one) === keyOf(pair))?.label ?? "";
  }

  /** Show the panel for the open pair; classes: of the head that predicts. */
  show(now, classes, describe) {
    this.now = now;
    if (classes) this.classes = classes;
    if (describe) this.describe = describe;
    this.onChange();
    this.box.hidden = !this.pairs.length && !isOwn(now);
    if (this.box.hidden || !this.classes) return;
    this.box.innerHTML = `${isOwn(now) ? this.question() : ""}${this.counted()}${this.teaching()}<p class="hint" role="status">${escaped(this.note)}</p>`;
  }

  /** Take no label until the pair on the screen has settled. */
  hold(on) {
    this.held = on;
    for (const one of this.box.querySelectorAll(".labels button, .labels input")) one.disabled = on;
  }

  /** Labelled pairs from a table: count them, and offer to teach them. */
  add(pairs) {
    const add = (all, { vis, tac, label, said: found, name }) => withPair(all, { vis, tac, label, said: found, name });
    this.changed(pairs.reduce(add, this.pairs));
  }

  question() {
    const chosen = this.labelOf(this.now);
    const off = this.held ? " disabled" : "";
    const names = [...new Set([...this.classes, ...this.pairs.map((one) => one.label)])];
    const buttons = names.map(
      (name) =>
        `<button type="button" data-label="${escaped(name)}"${off} aria-pressed="${name === chosen}">${escaped(name)}</button>`,
    );
    return `<header><h3>What is it really?</h3></header><form class="row labels">${buttons.join("")}<label>other <input type="text" name="label" maxlength="40" size="10"${off}></label><button type="submit"${off}>Add</button></form>`;
  }

  counted() {
    if (!this.pairs.length)
      return '<p class="hint">Choose the class, and the page counts how often it is right about your pairs.</p>';
    const found = tally(this.pairs);
    const parts = READINGS.filter(([reading]) => found[reading]).map(
      ([reading, title, sign]) =>
        `<span><span class="sign ${sign}"></span>${title.toLowerCase()} <b>${found[reading].right} of ${found[reading].of}</b></span>`,
    );
    const chips = this.pairs.map(
      (one) =>
        `<li><button type="button" class="open" data-key="${escaped(keyOf(one))}">${escaped(one.label)}<small>${escaped(one.name)}</small></button><button type="button" class="drop" data-key="${escaped(keyOf(one))}" aria-label="Forget ${escaped(one.name)}">×</button></li>`,
    );
    const from = provenance({
      head: "the head as trained",
      source: this.source,
      pairs: `your ${this.pairs.length} labelled pairs`,
      known: visit.profile ? "a profile of your pictures" : "nothing",
    });
    return `<div class="tally"><b>Right so far:</b> ${parts.join(" ")}</div>${from}<ul class="chips">${chips.join("")}</ul>`;
  }

  teaching() {
    if (!this.pairs.length) return "";
    const lacking = missing(this.pairs);
    const use = this.inUse ? "Back to the head as trained" : "Predict with the taught head";
    return `<div class="row"><button type="button" class="main teach" ${lacking ? "disabled" : ""}>Teach it my pairs</button>${
      this.report
        ? `<button type="button" class="use" aria-pressed="${this.inUse}">${use}</button><button type="button" class="save-head">Save the taught head</button>`
        : ""
    }<button type="button" class="save-set" title="Their embeddings, as a file for this page and the commands">Save my pairs as a set</button><button type="button" class="save-pictures" title="The pictures in folders by class, for omnivat embed">Save the pictures</button></div>${lacking ? `<p class="hint">${escaped(lacking)}</p>` : ""}${this.report ? reportHtml(this.report, this.labels, this.source) : ""}`;
  }

  /** Count the pair on the screen by what the head as trained predicts for exactly this pair. */
  async label(label) {
    const { now } = this;
    if (!label || this.held || !isOwn(now)) return;
    await attempt(() => this.count(now, label, this.describe(now)), this.say);
  }

  /** Count a labelled pair by what the head as trained predicts for it. */
  async count(pair, label, name) {
    const { classes, pairs } = await ask("many", { pairs: [pair] });
    this.changed(withPair(this.pairs, { ...pair, label, said: said(classes, pairs[0].readings), name }));
  }

  /** Labels changed: discard what was taught from the old ones. */
  changed(pairs) {
    this.pairs = pairs;
    this.report = null;
    this.labels = null;
    this.counting.abort();
    this.note = "";
    const used = this.inUse;
    this.inUse = false;
    this.show(this.now);
    if (used) this.onAgain();
    else this.onLabel();
  }

  async teach() {
    this.say("Teaching…");
    await attempt(async () => {
      this.report = await ask("teach", { lessons: lessonsFor(this.pairs, {}) });
      this.note = "";
      this.inUse = true;
      this.show(this.now);
      this.onAgain();
      this.curve();
    }, this.say);
  }

  /** What fewer labels would have taught; a page without a server has no such curve. */
  async curve() {
    this.counting.abort();
    const { signal } = (this.counting = new AbortController());
    await attempt(
      async () => {
        this.labels = await ask("curve", { lessons: lessonsFor(this.pairs, {}) }, signal);
        this.$(".taught").insertAdjacentHTML("beforeend", curveHtml(this.labels)); // what is being typed stays
      },
      () => {},
    );
  }

  async keep(path, name) {
    await attempt(async () => {
      save(name, await made(path, { lessons: lessonsFor(this.pairs, {}) }));
    }, this.say);
  }

  /** The pictures still in this browser, in folders for `omnivat embed`. */
  async keepPictures() {
    const files = [];
    for (const [number, pair] of this.pairs.entries()) {
      for (const modality of IMAGES) {
        const blob = pair[modality] && (await bytesOf(pair[modality], modality));
        if (!blob) continue;
        const label = pair.label.replaceAll(/[\\/:]/g, "_");
        const name = `my-pairs/My pairs/${label}/${number}_${modality}.${ending(blob)}`;
        files.push([name, new Uint8Array(await blob.arrayBuffer())]);
      }
    }
    if (!files.length) return this.say("This browser no longer has pictures of these pairs.");
    save("my-pictures.zip", new Blob(zipped(files), { type: "application/zip" }));
  }

  say = (sentence) => {
    this.note = sentence;
    this.$("[role=status]").textContent = sentence;
  };
}

const ending = ({ type }) =>
  ({ "image/png": "png", "image/webp": "webp", "image/tiff": "tif", "image/bmp": "bmp" })[type] ?? "jpg";

/** What labels bring: the mean share of right pairs over objects of each class, in the band of all draws. */
export function curveHtml({ points, words }) {
  const last = points.at(-1).objects;
  const scale = new Scale({ wide: 340, high: 150, pad: { left: 46, right: 12, top: 10, bottom: 22 }, xs: [1, last] });
  const line = (of) => scale.line(points.map((one) => [one.objects, one[of]]));
  const band = points.toReversed().map((one) => `L${scale.x(one.objects)} ${scale.y(one.low)}`);
  const ticks = [1, last].map((count) => [count, `${count} object${count > 1 ? "s" : ""} a class`]);
  const drawn = `<svg viewBox="0 0 340 150" role="img" aria-label="Right pairs by labelled objects of a class: ${points.map((one) => `${one.objects}: ${percent(one.right)}`).join(", ")}">${scale.grid([0, 0.5, 1], percent)}${scale.ticks(ticks)}<path class="band" d="${line("high")}${band.join("")}Z"/><path class="mean" d="${line("right")}"/></svg>`;
  return `<div class="chart labels-bring"><h4>How many more labels?</h4><p>${escaped(words)}</p>${points.length > 1 ? `${drawn}<p class="hint">Each pair is predicted by a head taught without it. Line: mean of ten draws of the objects that teach; band: from the least to the most.</p>` : ""}</div>`;
}

/** Before and after, pair by pair. */
function reportHtml({ judged, right, share }, labels, source) {
  const cell = (label, said) =>
    `<td class="${said === label ? "right" : "wrong"}">${said === label ? "✓" : "✗"} ${escaped(said)}</td>`;
  const rows = judged.map((one) =>
    row(
      escaped(one.label),
      [one.before, one.after].map((said) => cell(one.label, said)),
    ),
  );
  const step = Math.round(100 / judged.length);
  return `<div class="taught"><p><b>Right before: ${right.before} of ${judged.length}. After: ${right.after} of ${judged.length}.</b></p>
    ${provenance({ head: "heads taught without the pair", source: `${source} and your other pairs`, pairs: `your ${judged.length} labelled pairs`, known: "the labels of the others" })}
    <p class="hint">The head's own probabilities enter with weight ${share.toFixed(2)}, and a linear map learned from your pairs is added. Features do not change. One pair of each class, or a tenth of them, is left out at a time. One pair is ${step} points here.</p>
    ${table("Your pairs before and after teaching", ["It is", "before", "after"], rows)}${labels ? curveHtml(labels) : ""}</div>`;
}
