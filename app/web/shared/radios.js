/** A radio group: arrow keys move, Tab enters the group once. */

import { html } from "./text.js";

/** @type {Record<string, number>} */
const ARROWS = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };

/** Return the state of a radio button, as attributes. @param {boolean} on */
export const checked = (on) => html`aria-checked="${String(on)}" tabindex="${on ? 0 : -1}"`;

/** Buttons of which one is chosen; `name` is of what.
 * @param {{key: string, label: Markup, title?: string}[]} options @param {string} chosen */
export const radios = (options, chosen, name = "") =>
  html`${options.map(
    ({ key, label, title = "" }) =>
      html`<button role="radio" data-choice="${name}" data-key="${key}" title="${title}" ${checked(key === chosen)}>
        ${label}</button>`,
  )}`;

/** Let arrow keys choose the next button of a group, or the one before; tabs that are not Gradio's are one, too. */
export function followArrows() {
  document.addEventListener("keydown", (event) => {
    const button = /** @type {Found} */ (event.target);
    const by = ARROWS[event.key];
    if (!by || !button.matches(".ov [role=radio], .site [role=tab]")) return;
    event.preventDefault();
    const group = [...button.closest("[role=radiogroup], [role=tablist]").querySelectorAll("[role=radio], [role=tab]")];
    const next = group.at((group.indexOf(button) + by) % group.length);
    next.click();
    next.focus();
  });
}
