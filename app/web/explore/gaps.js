/** Chapter 2: whether p closes the gaps; both gaps and the chosen pair with its tree on the map, at every stop. */

import { address, ask, attempt, bytesOf, inSet, json, once } from "../shared/api.js";
import { thumbnail, verdict } from "../shared/card.js";
import { choices } from "../shared/facts.js";
import { orderText } from "../shared/frames.js";
import { verdictOn } from "../shared/gap-words.js";
import { framesBy, headLabel, heads } from "../shared/headsets.js";
import { asText, axis, GAPS, values } from "../shared/measures.js";
import { best, ends } from "../shared/numbers.js";
import { journeyStop, starAt } from "../shared/pair-marks.js";
import { treeSvg } from "../shared/pair-tree.js";
import { colouring } from "../shared/palette.js";
import { checked } from "../shared/radios.js";
import { awaited } from "../shared/ready.js";
import { OUTPUT, stageNamed, stepsOf } from "../shared/stages.js";
import { can, modeOf, OWN_MODE, sensorOf, TABLES } from "../shared/tables.js";
import { rightAt, whence } from "./chapters.js";
import { headIn, headText, pairOf, rowOf } from "./gap-pair.js";
import { map, shapeWords, showLayers } from "./maps.js";
import { framesOfMode } from "./modes.js";
import { $, draw, fill, html, options, percent, put, scene, send, showWords, state } from "./root.js";

const SIDE = 66; // CSS pixels of a picture
const STOPS = 21; // at most, of a map without UMAP
const IMAGES = /** @type {const} */ ([
  { name: "vis", title: "photo" },
  { name: "tac", title: "touch" },
]);

export const chosenHead = () => headIn(state, scene.sets);

/** @type {WeakMap<Frames, Frames>} */
const fewer = new WeakMap();

/** Return frames at the stops that their map of the output has by UMAP. @param {Frames} frames */
export function atStops(frames) {
  const known = fewer.get(frames);
  if (known) return known;
  const { length } = frames.orders;
  const even = Array.from({ length: Math.min(STOPS, length) }, (_, i, count = Math.min(STOPS, length)) =>
    Math.round((i * (length - 1)) / Math.max(1, count - 1)),
  );
  const made = frames.only(frames.meta.maps[`umap/${OUTPUT}`]?.orders ?? even);
  fewer.set(frames, made);
  return made;
}

/** Return the frames of the head in the address at their stops; null if others are wanted by then.
 * @param {(sentence: string) => void} say */
export async function framesOfHead(say) {
  const { mode, head } = chosenHead();
  const { by } = state;
  offer();
  const quiet = () => {};
  const frames = head
    ? await attempt(() => framesBy(head, scene.own, quiet, quiet), say)
    : await framesOfMode(say, scene.modes.includes(mode) ? mode : OWN_MODE);
  return frames && by === state.by ? atStops(frames) : null;
}

/** Fill the choice of heads: the modes of p of each set, and the heads beside the first. */
async function offer() {
  const { sets } = scene;
  const home = sets.find(({ shown }) => shown);
  const listed = home ? [home, ...sets.filter(({ shown }) => !shown)] : [{ name: "", title: "" }];
  const groups = await Promise.all(
    listed.map(async (row) => {
      const set = row === listed[0] ? "" : row.name;
      const { modes } = await choices(set);
      const some = [OWN_MODE, ...modes.filter((mode) => mode !== OWN_MODE)].map((mode) => [
        headText({ set, mode }),
        titleOf(mode),
      ]);
      return { title: row.title, rows: some };
    }),
  );
  const others = (await heads().catch(() => [])).filter(({ name, problem }) => name && !problem);
  for (const head of others) groups[0].rows.push([headText({ head: head.name }), headLabel(head)]);
  put(
    $(".of-head"),
    html`${groups.map(({ title, rows }) =>
      title
        ? html`<optgroup label="${title}">
      ${options(rows, state.by)}</optgroup>`
        : options(rows, state.by),
    )}`,
  );
}

/** @param {string} mode */
const titleOf = (mode) => TABLES.modes.find(({ id }) => id === mode)?.help ?? mode;

/** Show the answer to the chapter's question. */
export function tell() {
  const { frames, stop, facts } = scene;
  const outcome = verdictOn(frames.whole ?? frames);
  const title = "Does p close the two gaps?";
  if (!outcome) return showWords({ title, figure: html`This needs a head.`, remark: html`` });
  const away = can(modeOf(frames), "what-if") && stop !== frames.stop(frames.learned) && rightAt(frames, stop);
  const remark = away
    ? html`The weights belong to p = ${orderText(+frames.learned.toFixed(2))}. Here ${percent(away)} of pairs in unseen
      domains are correct, there ${percent(rightAt(frames, frames.stop(frames.learned)))}: a small gap alone is worth
      nothing.${whence(frames, stop, facts.unseen)}`
    : html``;
  return showWords({ title, figure: html`<b>${outcome.answer}</b> ${outcome.words}`, remark });
}

/** Draw what follows p: bars, steps, the pair and its tree. */
export function show() {
  if (scene.frames.headless) return;
  showBars();
  showSteps();
  showPair();
}

/** Return one axis for both gaps at every step and stop. */
const top = () => Math.max(...GAPS.map(({ id }) => axis(scene.frames.whole ?? scene.frames, id)[1]));

/** Show both gaps of the open step, each with its range over p. */
function showBars() {
  const { frames, stop } = scene;
  const [stage, most] = [state.stage, top()];
  const rows = GAPS.map(({ id, title, between, signals, help }) => {
    const all = values(frames.whole ?? frames, id, stage) ?? [];
    const now = values(frames, id, stage)?.[stop] ?? NaN;
    const [low, high] = ends(all);
    const what = (frames.signals && signals) || between;
    return html`<div class="gap-row ${id}" title="${help}"><span class="who"><b>${title}</b> <small>
      ${what}</small></span><span class="scale" style="--to:${now / most};--low:${low / most};--high:${high / most}">
      <i class="bar"></i><i class="range"></i></span><output>${asText(id, now, 2)}</output></div>`;
  });
  draw($(".gap-bars"), html`${rows}`);
}

/** Show the steps of the head as stairs of both gaps; each opens its map. */
function showSteps() {
  const { frames, stop } = scene;
  const most = top();
  const steps = stepsOf(frames).map(({ id, step, brief, help }) => {
    const gaps = GAPS.map((row) => ({ ...row, now: values(frames, row.id, id)?.[stop] ?? NaN }));
    const words = gaps.map(({ id, title, now }) => `${title.toLowerCase()} ${asText(id, now, 2)}`);
    const bars = gaps.map(
      ({ id, now }) =>
        html`<span class="${id}" style="--to:${now / most}"><output>${asText(id, now, 2)}</output><i></i></span>`,
    );
    return html`<button role="radio" data-stage="${id}" title="${help}" aria-label="${step}: ${words.join(", ")}"
      ${checked(id === state.stage)}><span class="columns" aria-hidden="true">${bars}</span>
      <span class="long">${step}</span><span class="brief">${brief}</span></button>`;
  });
  draw(
    $(".gap-steps"),
    html`<p>Both gaps after each step</p><div role="radiogroup" aria-label="Steps of the head; each opens its map">
      ${steps}</div>`,
  );
}

/** @type {Map<Ref, string>} */
const pictures = new Map(); // own picture -> its address in this browser

/** Return a picture of the chosen pair. @param {(typeof IMAGES)[number]} image */
function pictureOf({ name, title }) {
  const { frames, sprite, chosen } = scene;
  const { pair, row } = chosen;
  const ref = pair[name];
  if (!ref) return html`<span class="thumb none">no ${title}</span>`;
  if (row >= 0) return thumbnail(sprite, name === "tac" ? row + frames.pairs : row, SIDE, title);
  const [kind, rest] = ref.split(/:(.*)/s);
  const src = kind === "example" ? address(`example/${rest}/${name}`) : pictures.get(ref);
  if (src === undefined) keepPicture(ref, name);
  return src
    ? html`<img class="thumb" src="${src}" width="${SIDE}" height="${SIDE}" alt="${title}">`
    : html`<span class="thumb none">${title}</span>`;
}

/** Fetch one picture of a pair, keep its address for later, and draw the pair again. @param {Ref} ref
 * @param {Modality} name */
async function keepPicture(ref, name) {
  pictures.set(ref, "");
  const blob = await bytesOf(ref, name);
  if (!blob) return;
  pictures.set(ref, URL.createObjectURL(blob));
  showPair();
}

/** Return the stop of the chosen pair's journey at this p; -1 if it has none. */
const stopNow = () => journeyStop(scene.chosen.journey, scene.frames.orders[scene.stop]);

/** Show the chosen pair: its pictures, what is predicted at this p, and its tree. */
function showPair() {
  const { journey, note } = scene.chosen;
  const at = stopNow();
  const tree = journey && at >= 0 && journey.tree.parents.length > 0;
  fill(
    $(".chosen"),
    html`<div class="pair-now"><span class="thumbs">${IMAGES.map(pictureOf)}</span>${saidHtml(at)}</div>
      <div class="tree-now">${tree ? treeSvg(journey, at) : html`<p class="hint" role="status">${note}</p>`}</div>`,
  );
  light();
}

/** Return what is known of the chosen pair and predicted at this p: class and domain, and the prediction.
 * @param {number} at stop of the journey */
function known(at) {
  const { frames, stop, chosen } = scene;
  const { pair, row, journey } = chosen;
  const ofSet = row >= 0 ? verdict(frames, row, stop) : null;
  const example = (pair.tac ?? pair.vis ?? "").match(/^example:([^/]*)\/([^/]*)\//);
  const [domain, truth] = ofSet ? [ofSet.domain, ofSet.truth] : example ? example.slice(1) : ["", ""];
  const probabilities = at >= 0 && journey?.readings.fused?.[at];
  const said =
    journey && probabilities ? best(journey.classes, probabilities) : ofSet && { label: ofSet.said, share: NaN };
  return { domain, truth, said };
}

/** Return what the head predicts for the chosen pair at a stop, and whether that is a guess.
 * @param {number} at stop of the journey */
function saidHtml(at) {
  const { journey } = scene.chosen;
  const { domain, truth, said } = known(at);
  const strange = IMAGES.filter(({ name }) => journey?.images[name]?.guess).map(({ title }) => title);
  const right = said?.label === truth;
  const mark = truth && html`<span class="${right ? "right" : "wrong"}">${right ? "✓" : "✗"}</span> `;
  const guess = html`<p><b>${said?.label}?</b> A guess:
    the ${strange.join(" and the ")} ${strange.length > 1 ? "are" : "is"} unlike all training images.
    So is the position.</p>`;
  const sure = said && Number.isFinite(said.share) && ` ${percent(said.share)}`;
  const own = journey?.own && best(journey.own.classes, journey.own.readings.fused);
  const unsure = Object.values(journey?.own?.images ?? {}).some(({ guess }) => guess);
  return html`<div class="said-of"><p>${truth ? html`<b>${truth}</b>, ${sensorOf(domain)}` : html`<b>Your pair</b>`}
    </p>${said && (strange.length ? guess : html`<p>${mark}<b>${said.label}</b>${sure}</p>`)}${
      own &&
      html`<p>Linear maps, which have no p: <b>${own.label}${unsure && "?"}</b>
    ${!unsure && ` ${percent(own.share)}`}</p>`
    }
    ${
      journey &&
      !journey.maps[state.map] &&
      html`<p class="hint">A page without a server places this pair on the PCA
    map alone.</p>`
    }<button class="link try-own">Try your own pair</button></div>`;
}

let asking = new AbortController(); // a handle: of the request that is on its way

/** Open the chapter: the pair is the one that is most familiar to the head, unless another is chosen. */
export async function open() {
  const { set, frames } = scene;
  showKeys();
  if (frames.headless) return;
  if (state.pin === null && (set || !(state.vis || state.tac))) {
    const first = await attempt(
      () => once(`first ${set}`, () => json(inSet("first", set))),
      () => {},
    );
    if (scene.set !== set) return;
    send("arrived", { opening: first?.ref ?? null });
  }
  follow();
}

/** Fetch the journey once another pair or head is chosen, or more is known of the set. */
export function follow() {
  const { set, frames, chosen: before } = scene;
  if (!frames || frames.headless) return;
  const pair = pairOf(scene, state);
  const key = JSON.stringify([set, state.by, pair]);
  const row = rowOf(scene, pair);
  if (before.key === key) {
    if (before.row === row) return;
    send("arrived", { chosen: { ...before, row } });
    return repaint();
  }
  asking.abort();
  const { signal } = (asking = new AbortController());
  const chosen = { key, pair, row, journey: null, note: "Placing this pair and its tree at every stop…" };
  send("arrived", { chosen, node: -1 });
  repaint();
  awaited(travel(chosen, signal));
}

/** @param {ChosenPair} chosen @param {AbortSignal} signal */
async function travel({ key, pair }, signal) {
  const { head, mode } = chosenHead();
  const learn = (/** @type {Partial<ChosenPair>} */ more) => {
    if (scene.chosen.key !== key) return;
    send("arrived", { chosen: { ...scene.chosen, ...more } });
    repaint();
  };
  const question = { ...pair, head, ...(mode !== OWN_MODE && { mode }) };
  await attempt(
    async () => learn({ journey: await ask(inSet("journey", scene.set), question, signal) }),
    (/** @type {string} */ note) => learn({ note }),
  );
}

/** Show the domains on the map by their colours; one that is pointed at stands out. */
function showKeys() {
  const { frames } = scene;
  const groups = colouring(frames, "domain").groups(frames);
  draw(
    $(".map-keys"),
    html`${groups.map(
      ([name, colour]) => html`<span class="key" data-domain-key="${name}">
      <i style="background:${colour}"></i>${sensorOf(name)}${name === frames.source && html` <b>source</b>`}</span>`,
    )}
      <span class="map-shapes">${shapeWords(frames)}  ★ node</span>`,
  );
}

/** Light up the node under the pointer in the tree and on the map. @param {number} [node] */
export function light(node = scene.node) {
  if (node !== scene.node) {
    send("arrived", { node });
    map.paintMarks();
  }
  for (const disc of $(".tree-now").querySelectorAll("[data-node]"))
    disc.classList.toggle("lit", +disc.dataset.node === node);
}

/** Let one domain stand out; again, all. @param {string} [name] */
function point(name) {
  send("arrived", { highlight: name ? { kind: "domain", name } : null });
  showLayers();
}

let repaint = () => {}; // draws the map with the pair, and what is beside it

/** Let pointer and focus on a node light it, in the tree and on the map; `redraw` draws both.
 * @param {() => void} redraw */
export function listen(redraw) {
  repaint = () => map.frame && redraw();
  const keyed = (/** @type {At} */ { target }) => point(target.closest?.("[data-domain-key]")?.dataset.domainKey);
  $(".map-keys").addEventListener("pointerover", keyed);
  $(".map-keys").addEventListener("pointerleave", () => point());
  const of = (/** @type {At} */ { target }) => +(target.closest?.("[data-node]")?.dataset.node ?? -1);
  for (const kind of ["pointerover", "focusin"])
    $(".chosen").addEventListener(kind, (/** @type {At} */ event) => light(of(event)));
  for (const kind of ["pointerleave", "focusout"]) $(".chosen").addEventListener(kind, () => light(-1));
  map.marks.addEventListener("pointermove", ({ offsetX, offsetY }) => {
    if (state.chapter === "gaps") light(starAt(map.extras().slice(2), [offsetX, offsetY]));
  });
}

/** Announce the chosen pair and both gaps to a screen reader. */
export function announce() {
  const { frames, stop, chosen } = scene;
  const gaps = GAPS.map(
    ({ id, title }) => `${title.toLowerCase()} ${asText(id, values(frames, id, state.stage)?.[stop], 2)}`,
  );
  const { domain, truth, said } = known(stopNow());
  const pair = truth ? `pair${chosen.row >= 0 ? ` ${chosen.row}` : ""}, ${truth}, ${sensorOf(domain)}` : "your pair";
  $(".announcement").textContent = [
    `p ${orderText(frames.orders[stop])}, ${stageNamed(state.stage).step}`,
    ...gaps,
    `${pair}${said ? `, predicted ${said.label}` : ""}`,
  ].join(", ");
}
