/** Legend and filters: the meaning of each colour, and a switch for each name. */

import { colouring, TAC_COLOUR, VIS_COLOUR } from "./palette.js";
import { hidden, state, toggle } from "./store.js";
import { each, escaped } from "./text.js";

/** @type {[string, string, (f: any) => string[]][]} */
const KINDS = [
  ["domain", "Domains", (f) => f.domains],
  ["class", "Classes", (f) => f.classes],
  ["modality", "Modalities", () => ["VIS", "TAC"]],
];
const SIGNS = { VIS: "●", TAC: "▲" };

/** Draw the switches; those of the current colouring show their colours. */
export function showFilters(box, frames, onPoint) {
  const chosen = colouring(frames, state.colour);
  const colours = new Map(chosen.groups(frames));
  const legend = ["Correctness", "Confidence"].includes(chosen.label)
    ? `<fieldset class="legend"><legend>${chosen.label}</legend>${each([...colours], ([name, colour]) => `<span class="key"><i style="background:${colour}"></i>${escaped(name)}</span>`)}</fieldset>`
    : "";
  box.innerHTML =
    legend +
    each(KINDS, ([kind, title, names]) => {
      const off = hidden(kind);
      const switches = names(frames).map((name) => {
        const colour = chosen.label.toLowerCase() === kind ? colours.get(name) : null;
        const sign =
          kind === "modality"
            ? `<i class="sign" style="color:${colour ?? (state.colour === "modality" ? { VIS: VIS_COLOUR, TAC: TAC_COLOUR }[name] : "currentColor")}">${SIGNS[name]}</i>`
            : colour
              ? `<i style="background:${colour}"></i>`
              : "";
        return `<label data-kind="${kind}" data-name="${escaped(name)}"><input type="checkbox" ${off.has(name) ? "" : "checked"}>${sign}<span>${escaped(name)}${name === frames.source ? ' <b class="source" title="the domain that the head was trained on">source</b>' : ""}</span></label>`;
      });
      return `<fieldset><legend>${title}</legend>${switches.join("")}</fieldset>`;
    });
  box.onchange = (event) => {
    const label = event.target.closest("label");
    toggle(label.dataset.kind, label.dataset.name);
  };
  box.onpointerover = (event) => {
    const label = event.target.closest("label");
    onPoint(label ? { kind: label.dataset.kind, name: label.dataset.name } : null);
  };
  box.onpointerleave = () => onPoint(null);
}

/** A function from a point's index to whether it is shown. */
export function shownBy(frames) {
  const domains = frames.domains.map((name) => !hidden("domain").has(name));
  const classes = frames.classes.map((name) => !hidden("class").has(name));
  const modalities = ["VIS", "TAC"].map((name) => !hidden("modality").has(name));
  return (point) => {
    const tac = point >= frames.pairs;
    const pair = tac ? point - frames.pairs : point;
    return modalities[+tac] && domains[frames.domain[pair]] && classes[frames.label[pair]];
  };
}
