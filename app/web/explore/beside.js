/** A second map beside the first: the same pairs at a step, a p and by a method of its own; both are linked. */

import { attempt, Refusal } from "../shared/api.js";
import { Cloud } from "../shared/cloud.js";
import { classOf, orderText } from "../shared/frames.js";
import { framesBy, headLabel, heads, isMethod, methodsFor } from "../shared/headsets.js";
import { axes, axisNames, lassoLine } from "../shared/marks.js";
import { means } from "../shared/means.js";
import { ACCURACY, values } from "../shared/measures.js";
import { listen } from "../shared/pointer.js";
import { ofFrames } from "../shared/provenance.js";
import { OUTPUT, stageNamed, stepsOf } from "../shared/stages.js";
import { making, tell } from "../shared/view.js";
import { figure, gaps, kindOf, map, pairLines, showLayers, shown } from "./maps.js";
import { $, change, fill, grouped, html, options, put, scene, send, state } from "./root.js";
import { isDouble, painted } from "./scene.js";

/** Return the accuracy of frames at a stop on the pairs of the first map, and whose it is; only where the head
 * predicts.
 * @type {(frames: Frames, stage: string, stop: number) => false | null | Html} */
export const right = (frames, stage, stop) => {
  const share = stage === OUTPUT && figure("accuracy", ACCURACY, values(frames, ACCURACY, stage), stop);
  return share && html`${share}${ofFrames(frames, stop, "the same pairs", null)}`;
};

/** @type {Cloud} */
let cloud;
const stage = () => stageNamed(state.stage2).id;
/** Return whether the frames are those that are chosen. */
const isReady = () => !state.head2 || scene.other?.name === state.head2;
const framesOf = () => (state.head2 && isReady() && scene.other?.frames) || scene.frames;
/** Return its own p, or that of the first map until it has one. @param {Frames} frames */
const stopOf = (frames) => frames.stop(state.p2 ?? scene.frames.orders[scene.stop]);

/** Make the map. @param {Pointing} on */
function build(on) {
  const box = document.createElement("div");
  Object.assign(box, { className: "map", role: "application", ariaLabel: "Second map of the same features" });
  $(".beside").append(box);
  cloud = new Cloud(box, 2 * scene.own.pairs);
  const drawing = listen(cloud, on);
  cloud.painters = [
    axes(() => axisNames(kindOf(stage(), framesOf()))),
    means(() => painted(scene, state, framesOf()), shown),
    pairLines,
    (x) => lassoLine(x, drawing.polygon),
  ];
  cloud.onView = (view) => map.setView(view, true);
  map.onView = (view) => cloud.setView(view, true);
}

/** Move its own p. @param {number} p */
export const moveTo = (p) => change({ p2: framesOf().orders[framesOf().stop(p)] });

/** Offer what predicts: the heads, and a method fitted on the source. */
async function offer() {
  const [first, ...more] = await heads().catch(() => [{ name: "", folder: "the head", problem: "unknown" }]);
  const others = more.filter(({ problem }) => !problem).map((head) => [head.name, headLabel(head)]);
  put($(".beside .by"), options([["", headLabel(first)], ...others, ...methodsFor(scene.own)], state.head2));
}

/** Open or close it, with what is chosen. @param {Pointing} on */
export async function follow(on) {
  const open = isDouble(scene, state);
  $(".maps").classList.toggle("two", open);
  $(".beside").hidden = $(".now .pane").hidden = !open;
  $(".changed").hidden = true;
  if (!open) return;
  if (!cloud) {
    build(on);
    await offer();
  }
  if (cloud.count !== 2 * scene.own.pairs) cloud.hold(2 * scene.own.pairs);
  const steps = stepsOf(scene.frames).map(({ id, title }) => [id, title]);
  put($(".beside .step"), options(steps, stage()));
  show();
  await load();
}

/** Load what predicts, if it is not there. @returns {Promise<void>} */
export async function load() {
  const name = state.head2;
  const wait = $(".side-wait");
  if (isReady()) return;
  await attempt(
    async () => {
      const frames = await framesBy(name, scene.own, (step) => tell(wait, making(step)), loadFiner);
      if (frames.pairs !== scene.own.pairs) throw new Refusal("The map of this head belongs to another set.");
      if (state.head2 !== name) return;
      send("arrived", { other: { name, frames } });
      tell(wait, "");
      show();
    },
    (/** @type {string} */ words) => state.head2 === name && tell(wait, words),
  );
}

/** Show finer frames of what predicts. */
function loadFiner() {
  send("arrived", { other: null });
  load();
}

/** Draw both titles, the map, and what changes from one to the other. */
export function show() {
  if (!cloud || !isDouble(scene, state)) return;
  const frames = framesOf();
  const stop = stopOf(frames);
  const p = frames.orders[stop];
  const same = frames === scene.frames && stop === scene.stop; // the accuracy stands beside the first map
  const { unseen } = scene.facts;
  const slider = $(".its-p");
  const fixed = isMethod(state.head2);
  $(".beside .by").value = state.head2;
  Object.assign(slider, { min: frames.orders[0], max: frames.orders.at(-1), value: p, disabled: fixed });
  $(".beside output").textContent = fixed ? "–" : orderText(p);
  showLayers(cloud, frames, stop);
  const there = frames.positions(kindOf(stage(), frames), stage(), stop);
  if (there) cloud.show(there);
  cloud.box.dataset.order = String(p);
  fill(
    $(".pane-title"),
    html`${isReady() && [gaps(frames, stage(), stop), " ", !same && right(frames, stage(), stop)]}`,
  );
  fill(
    $(".now .pane"),
    html`<b>${stageNamed(state.stage).title}</b> p
      = ${orderText(scene.frames.orders[scene.stop])} ${gaps(scene.frames, state.stage, scene.stop)}`,
  );
  const counts = unseen?.pairs.counts;
  $(".changed").hidden = !counts || !isReady() || same;
  if (counts && !$(".changed").hidden) put($(".changed"), changes(counts, frames, stop));
}

/** Return the predictions that differ, of the pairs that count.
 * @param {ArrayLike<number>} counts @param {Frames} frames @param {number} stop */
function changes(counts, frames, stop) {
  const said = (/** @type {Frames} */ of, /** @type {number} */ at) => (/** @type {number} */ pair) =>
    of.classes[of.prediction[at * of.pairs + pair]];
  const truth = (/** @type {number} */ pair) => classOf(scene.frames, pair);
  const pairs = Array.from(counts, (_, pair) => pair).filter((pair) => counts[pair]);
  return sentence(counted(pairs, said(scene.frames, scene.stop), said(frames, stop), truth));
}

export const paintMarks = () => isDouble(scene, state) && cloud?.paintMarks();

/** @typedef {(pair: number) => string} ClassOf */
/** The number of pairs, and of changed predictions: corrected, broken, still wrong. Each function gives the class of a
 * pair. @param {number[]} pairs @param {ClassOf} left @param {ClassOf} right @param {ClassOf} truth */
export function counted(pairs, left, right, truth) {
  const changed = pairs.filter((pair) => left(pair) !== right(pair));
  const corrected = changed.filter((pair) => right(pair) === truth(pair)).length;
  const broken = changed.filter((pair) => left(pair) === truth(pair)).length;
  return { all: pairs.length, corrected, broken, wrong: changed.length - corrected - broken };
}

/** Return the sentence below both maps. @param {ReturnType<typeof counted>} counts */
export function sentence({ all, corrected, broken, wrong }) {
  if (!all)
    return html`There are no test pairs here: each pair was used for training or has a class that the head does not
      know.`;
  return html`From the left map to the right, <b>${grouped(corrected + broken + wrong)}
    </b> of ${grouped(all)} predictions change: <span class="right">${grouped(corrected)} corrected</span>
    , <span class="wrong">${grouped(broken)} broken</span>, ${grouped(wrong)} still wrong.`;
}
