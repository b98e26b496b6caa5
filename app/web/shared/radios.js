/** A radio group: arrow keys move, Tab enters the group once. */

import { html, put } from "./text.js";

/** @type {Record<string, number>} */
export const ARROWS = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };

/** Returns a function that marks the chosen one.
 * @param {Found} box @param {{key: string, label: string, title?: string}[]} options @param {() => string} chosen
 * @param {(key: any) => unknown} onChoose */
export function radios(box, options, chosen, onChoose) {
  put(
    box,
    html`${options.map(
      ({ key, label, title = "" }) =>
        html`<button type="button" role="radio" data-key="${key}" title="${title}">${label}</button>`,
    )}`,
  );
  const buttons = [...box.children];
  /** Choose, and keep the focus where the choice is made again. @param {string} key */
  const choose = (key) => {
    onChoose(key);
    box.querySelector(`[data-key="${CSS.escape(key)}"]`)?.focus();
  };
  box.onclick = (/** @type {Found} */ { target }) => {
    const button = target.closest("button");
    if (button) choose(button.dataset.key);
  };
  box.onkeydown = (/** @type {KeyboardEvent} */ event) => {
    const by = ARROWS[event.key];
    if (!by) return;
    event.preventDefault();
    const at = options.findIndex(({ key }) => key === chosen());
    choose(options[(at + by + options.length) % options.length].key);
  };
  const show = () => {
    for (const button of buttons) {
      const on = button.dataset.key === chosen();
      button.setAttribute("aria-checked", on);
      button.tabIndex = on ? 0 : -1;
    }
  };
  show();
  return show;
}
