/** The Save menu: the map as a picture, points as a table, a link to the view. */

import { attempt, inSet, made } from "../shared/api.js";
import { orderText } from "../shared/frames.js";
import { axisNames } from "../shared/marks.js";
import { colouring } from "../shared/palette.js";
import { save } from "../shared/save.js";
import { stageNamed } from "../shared/stages.js";
import { modeOf, sensorOf } from "../shared/tables.js";
import { csv, png, svg } from "./exports.js";
import { showGrid } from "./grid.js";
import { kindOf, METHODS, map, shown } from "./maps.js";
import { $, html, joined, put, scene, state } from "./root.js";
import { filtering, painted } from "./scene.js";
import { loadTags, tagsCsv } from "./tags.js";

/** Copy the address, together with the map's picture if one is on the screen; return what was done, in words.
 * @param {boolean} pictured */
export async function share(pictured) {
  const text = location.href;
  const { clipboard } = navigator;
  try {
    if (!pictured) throw new Error("There is no map.");
    const link = new Blob([text], { type: "text/plain" });
    await clipboard.write([new ClipboardItem({ "text/plain": link, "image/png": picture() })]);
    return "Copied";
  } catch {
    return clipboard.writeText(text).then(
      () => "Link copied",
      () => "Copy the address",
    );
  }
}

/** Show something above the page; a click beside it closes it. @param {Html} content @returns {Found} */
function popUp(content) {
  const box = $(".shared");
  put(box, content);
  box.showPopover?.();
  return box;
}

/** Show the link to this view. */
export function showLink() {
  const box = popUp(html`<h3>This view</h3><input type="text" readonly aria-label="Link to this view">`);
  const field = box.querySelector("input");
  field.value = location.href;
  field.onfocus = () => field.select();
}

/** Name the contents of the CSV in the menu. */
export function labelCsv() {
  const { size } = scene.selected;
  const what = size
    ? `The ${size} selected points`
    : filtering(scene, state).length
      ? "The points shown"
      : "All points";
  $('.menu [data-save="csv"]').textContent = `${what} as CSV`;
}

/** Return what a saved map states of itself. */
function caption() {
  const { frames, stop } = scene;
  const { simulated, origin } = frames.meta.embeddings;
  const words = [
    "OmniVaT",
    stageNamed(state.stage).title,
    !frames.headless && `p = ${orderText(frames.orders[stop])}`,
    modeOf(frames).caption,
    frames.source && `trained on ${sensorOf(frames.source)}`,
    METHODS[state.map],
    ...filtering(scene, state),
    simulated ? "simulated data" : origin,
    "● VIS ▲ TAC",
  ];
  return joined(words, " · ");
}

const colours = () => colouring(painted(scene, state), state.colour);
const legend = () => colours().groups(painted(scene, state));
const picture = () => png(map, caption(), legend());
const say = (/** @type {string} */ sentence) => popUp(html`<p role="alert">${sentence}</p>`);

/** Load the tags of a CSV and say how many there are. @param {Found} input */
export async function loadFile(input) {
  const report = (/** @type {string} */ sentence) => {
    $(".load-tags").title = sentence;
    $(".save").open = false;
    say(sentence);
  };
  await attempt(async () => {
    report(`${loadTags(scene.own, await input.files[0].text())} pairs have a tag now.`);
    showGrid();
    labelCsv();
  }, report);
  input.value = "";
}

/** Save the selected points, or those shown, as a table. @param {string} name */
function saveCsv(name) {
  const { frames, selected, stop } = scene;
  const { frame } = map;
  if (!frame) return;
  const points = selected.size ? [...selected] : Array.from({ length: 2 * frames.pairs }, (_, i) => i).filter(shown);
  save(`${name}${selected.size ? "-selected" : ""}.csv`, csv(painted(scene, state), points, frame, stop, state));
}

/** @type {Record<string, (name: string) => unknown>} */
const FILES = {
  csv: saveCsv,
  png: async (name) => save(`${name}.png`, await picture()),
  svg: (name) => save(`${name}.svg`, svg(map, caption(), legend(), axisNames(state.map))),
  tags: () => save("omnivat-tags.csv", tagsCsv(scene.frames, scene.facts.pairs?.name)),
  /** The open map, the curves and the staircase as one page that the server makes. */
  figure: async (name) => {
    const { frames, set, stop, mode } = scene;
    const { stage } = state;
    const question = { stage, map: kindOf(stage), colour: colours().id, mode, order: frames.orders[stop] };
    await attempt(async () => save(`${name}.html`, await made(inSet("save/figure", set), question)), say);
  },
};

/** Save the view as one of these files. @param {string} kind */
export async function saveAs(kind) {
  await FILES[kind](`omnivat-${state.stage}-p${orderText(scene.frames.orders[scene.stop])}`);
  $(".save").open = false;
}
