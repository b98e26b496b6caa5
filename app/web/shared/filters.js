/** Legend and filters: the meaning of each colour, and a switch for each name. */

import { colouring } from "./palette.js";
import { hidden, state, toggle } from "./store.js";
import { sensorOf } from "./tables.js";
import { html, put } from "./text.js";

/** @type {[Filter, string, (f: Frames) => string[]][]} */
const KINDS = [
  ["domain", "Domains", (f) => f.domains],
  ["class", "Classes", (f) => f.classes],
  ["modality", "Modalities", () => ["VIS", "TAC"]],
];
/** @type {Record<string, string>} */
const SIGNS = { VIS: "●", TAC: "▲" };

/** Return the names of groups beside their colours.
 * @param {[name: string, colour: string][]} groups
 * @param {string} [source] */
export const keys = (groups, source) =>
  html`${groups.map(
    ([name, colour]) =>
      html`<span class="key"><i style="background:${colour}"></i>${name}
        ${name === source && html` <b>source</b>`}</span>`,
  )}`;

/** Draw the switches; those of the current colouring show their colours.
 * @param {Found} box @param {Frames} frames @param {(filter: {kind: Filter, name: string} | null) => void} onPoint */
export function showFilters(box, frames, onPoint) {
  const { id, title, groups } = colouring(frames, state.colour);
  const colours = new Map(groups(frames));
  /** @param {Filter} kind @param {string} name */
  const sign = (kind, name) => {
    const colour = id === kind && colours.get(name);
    if (kind === "modality") return html`<i class="sign" style="color:${colour || "currentColor"}">${SIGNS[name]}</i>`;
    return colour && html`<i style="background:${colour}"></i>`;
  };
  /** @param {Filter} kind @param {string} name */
  const choice = (kind, name) =>
    html`<label data-kind="${kind}" data-name="${name}">
      <input type="checkbox"${!hidden(kind).has(name) && html` checked`}>${sign(kind, name)}
      <span>${kind === "domain" ? sensorOf(name) : name}
      ${name === frames.source && html` <b class="source" title="the domain that the head was trained on">source</b>`}
      </span></label>`;
  const own = KINDS.some(([kind]) => kind === id);
  put(
    box,
    html`${!own && html`<fieldset class="legend"><legend>${title}</legend>${keys([...colours])}</fieldset>`}${KINDS.map(
      ([kind, title, names]) =>
        html`<fieldset><legend>${title}</legend>${names(frames).map((name) => choice(kind, name))}</fieldset>`,
    )}`,
  );
  /** @param {{target: Found}} event */
  const of = ({ target }) => target.closest("label")?.dataset;
  box.onchange = (/** @type {Found} */ event) => toggle(of(event).kind, of(event).name);
  box.onpointerover = (/** @type {Found} */ event) => onPoint(of(event) ?? null);
  box.onpointerleave = () => onPoint(null);
}

/** Return a function from a point's index to whether it is shown.
 * @param {Frames} frames @param {Pick<State, Filter>} address @returns {(point: number) => boolean} */
export function shownBy(frames, address = state) {
  const [domains, classes, modalities] = KINDS.map(([kind, , names]) => {
    const hides = hidden(kind, address);
    return names(frames).map((name) => !hides.has(name));
  });
  return (point) => {
    const tac = point >= frames.pairs;
    const pair = tac ? point - frames.pairs : point;
    return modalities[+tac] && domains[frames.domain[pair]] && classes[frames.label[pair]];
  };
}
