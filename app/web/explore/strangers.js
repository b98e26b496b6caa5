/** Unseen domains: look-alikes and each reading of them, every domain, confusion. */

import { thumbnail } from "../shared/card.js";
import { unseenPairs } from "../shared/provenance.js";
import { sensorOf } from "../shared/tables.js";
import { balance, barRow, scaleOf } from "./bars.js";
import { ofOwn } from "./chapters.js";
import { marked } from "./grid.js";
import { $, change, choice, html, options, percent, put, scene, send, state } from "./root.js";
import { strangePairs, UNSEEN } from "./scene.js";

/** @type {{key: Reading, label: string, title?: string}[]} */
const READINGS = [
  { key: "vis", label: "Photo", title: "Without the touch" },
  { key: "tac", label: "Touch", title: "Without the photo" },
  { key: "fused", label: "Both" },
];
const SHOWN = 3; // look-alikes with both pictures, at most
const ROOM = 165; // CSS pixels for one of them

/** Return look-alikes of unseen domains, one of each class; those that show the lesson come first: the photo misleads,
 * the touch does not.
 * @type {(scene: Pick<Scene, "frames" | "facts">) => number[]} */
export function lookAlikes({ frames, facts }) {
  const classOf = (/** @type {number} */ pair) => frames.label[pair];
  const shows = (/** @type {number} */ pair) => {
    const { vis, tac } = /** @type {Unseen} */ (facts.unseen).pairs.answers;
    return Number(vis[pair] !== classOf(pair)) + 2 * Number(tac[pair] === classOf(pair));
  };
  const alike = strangePairs({ frames, facts }).alike.sort((a, b) => shows(b) - shows(a));
  const classes = alike.map(classOf);
  return alike.filter((pair, i) => classes.indexOf(classOf(pair)) === i);
}

/** Show the facts about the head. */
export function show() {
  const { unseen } = scene.facts;
  if (!unseen) return;
  const measured = unseen.domains.some((domain) => domain["answers/fused"]); // else there are no test pairs
  for (const part of [$(".strangers"), $("[data-panel=confusion]"), $("[data-panel=domains]")])
    part.classList.toggle("nothing", !measured);
  $(".strangers .hint").hidden = true;
  showLookers(unseen);
  showReadings(unseen);
  put($(".each-domain"), bars(unseen));
  showConfusion();
}

/** Show both pictures of a few look-alikes, and what the head reads in each alone. @param {Unseen} unseen */
function showLookers(unseen) {
  const { frames, sprite, facts } = scene;
  const names = facts.pairs;
  const box = $(".lookers");
  box.hidden = !unseen.look_alikes || !names || !sprite;
  if (box.hidden || !names) return;
  const { clientWidth: wide } = $(".strangers");
  const shown = Math.max(1, Math.min(SHOWN, Math.floor(wide / ROOM)));
  const side = Math.min(110, Math.floor(wide / shown / 2) - 22);
  box.style.gridTemplateColumns = `repeat(${shown}, minmax(0, 1fr))`;
  const read = (/** @type {number} */ pair, /** @type {Modality} */ image, /** @type {string} */ label) => {
    const said = unseen.pairs.answers[image][pair];
    const right = said === frames.label[pair];
    const picture = thumbnail(sprite, image === "tac" ? frames.pairs + pair : pair, side, label);
    return html`<figure>${picture}<figcaption class="${right ? "right" : "wrong"}">
      ${marked(right, unseen.classes[said])}</figcaption></figure>`;
  };
  const buttons = lookAlikes(scene)
    .slice(0, shown)
    .map(
      (pair) =>
        html`<button data-pair="${pair}"><span class="thumbs">${read(pair, "vis", "photo")}
          ${read(pair, "tac", "touch")}</span>Is ${unseen.classes[frames.label[pair]]}; looks
          like ${names.looks_like[pair]}</button>`,
    );
  put(box, html`${buttons}`);
}

/** Show a bar for each reading: of the look-alikes, or of all unseen pairs where there are none.
 * @param {Unseen} unseen */
function showReadings({ look_alikes, unseen, chance }) {
  const buttons = READINGS.map(({ label, ...row }) => {
    const share = (look_alikes ?? unseen)[`answers/${row.key}`];
    const figure = share
      ? html`<b>${percent(share.share)}</b> <small>${(100 * share.low).toFixed(0)}–${(100 * share.high).toFixed(0)}
        </small>`
      : "–";
    return { ...row, label: html`<span>${label}</span>${scaleOf(share, chance)}<output>${figure}</output>` };
  });
  choice(".readings", "reading", buttons);
}

/** Return the bars of every domain, by the chosen reading. @param {Unseen} facts */
function bars(facts) {
  const { domains, unseen, chance } = facts;
  /** @type {`answers/${Reading}`} */
  const key = `answers/${state.reading}`;
  const row = (
    /** @type {string} */ name,
    /** @type {Share | undefined} */ share,
    /** @type {object} */ about,
    level = chance,
  ) => barRow(name, scaleOf(share, level), share ? percent(share.share) : "–", about);
  const rows = domains
    .filter((domain) => domain.pairs || domain[key])
    .map(({ name, is_source, pairs, ...domain }) => {
      const { always, uneven, words } = unevenness(facts, name);
      const about = {
        kind: is_source && "source",
        title: words,
        more: html`${is_source && html` <b class="tag source">training</b>`}
          <span class="sr">, ${pairs} test pairs</span>`,
      };
      return row(sensorOf(name), domain[key], about, uneven ? always : chance);
    });
  const title = html`Share of photos whose nearest touch in the same domain (by F̂) has the same class. The head reads
    each image alone.`;
  return html`${rows}<hr>${row("mean, unseen", unseen[key], { kind: "mean-row" })}
    ${row("retrieval", unseen.retrieval, { title })}
    ${ofOwn(scene.own, `its own test pairs and ${unseenPairs(scene.own, facts)}`)}`;
}

/** Return the balance of a domain's classes by the chosen reading, in words where they are uneven.
 * @param {Unseen} facts
 * @param {string} name */
function unevenness({ confusion }, name) {
  const found = balance(confusion[state.reading][name]);
  const { always, balanced, uneven } = found;
  const words =
    `The classes are uneven here: the mean over classes is ${percent(balanced)}, and always naming the largest ` +
    `class is correct for ${percent(always)}.`;
  return { ...found, words: uneven ? words : "" };
}

/** Show the confusion matrix of a domain by the chosen reading; the chosen cell is pressed. */
export function showConfusion() {
  const { cell, stranger } = scene;
  const facts = /** @type {Unseen} */ (scene.facts.unseen);
  const { classes, confusion, domains } = facts;
  const counts = confusion[state.reading][stranger];
  const most = Math.max(1, ...counts.flat());
  const names = [
    [UNSEEN, "all unseen domains"],
    ...domains.map(({ name, is_source }) => [name, `${sensorOf(name)}${is_source ? " (training domain)" : ""}`]),
  ];
  const button = (/** @type {number} */ count, /** @type {number} */ truth, /** @type {number} */ answer) => {
    const on = cell?.truth === truth && cell.answer === answer;
    return html`<td class="${truth === answer && "hit"}"><button aria-pressed="${String(on)}" data-truth="${truth}"
      data-answer="${answer}" style="--s:${((100 * count) / most).toFixed(0)}%"
      aria-label="${classes[truth]} predicted as ${classes[answer]}: ${count} pairs" ${!count && html`disabled`}>
      ${count || ""}</button></td>`;
  };
  const rows = counts.map(
    (row, truth) =>
      html`<tr><th scope="row">${classes[truth]}</th>${row.map((n, answer) => button(n, truth, answer))}</tr>`,
  );
  put($(".of-domain"), options(names, stranger));
  put(
    $(".confusion"),
    html`<table><thead><tr><th scope="col"><small>true ↓</small></th>
      ${classes.map((name) => html`<th scope="col" title="${name}">${name}</th>`)}</tr></thead>
      <tbody>${rows}</tbody></table>`,
  );
  $(".cell-words").textContent = cell
    ? "The map and the pictures show only these pairs, with the predictions at the current p."
    : `${unevenness(facts, stranger).words} Choose a cell to see its pairs on the map.`.trim();
}

/** Show the confusion matrix of another domain. @param {string} stranger */
export function chooseStranger(stranger) {
  send("arrived", { stranger });
  if (state.cell) change({ cell: "", sel: "" });
  showConfusion();
}

/** Filter the map by a cell; a second click shows all pairs. @param {number} truth @param {number} answer */
export function chooseCell(truth, answer) {
  const { cell, stranger } = scene;
  const again = cell?.truth === truth && cell.answer === answer;
  change(again ? { cell: "", sel: "" } : { cell: [truth, answer, stranger].join("~") });
}
