/** A radio group: arrow keys move, Tab enters the group once. */

import { each, escaped } from "./text.js";

export const ARROWS = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };

/** options: [{key, label, title}]. Returns a function that marks the chosen one. */
export function radios(box, options, chosen, onChoose) {
  box.innerHTML = each(
    options,
    ({ key, label, title = "" }) =>
      `<button type="button" role="radio" data-key="${key}" title="${escaped(title)}">${escaped(label)}</button>`,
  );
  const buttons = [...box.querySelectorAll("button")];
  /** Choose, and keep the focus where the choice is made again. */
  const choose = (key) => {
    onChoose(key);
    box.querySelector(`[data-key="${CSS.escape(key)}"]`)?.focus();
  };
  box.onclick = (event) => {
    const button = event.target.closest("button");
    if (button) choose(button.dataset.key);
  };
  box.onkeydown = (event) => {
    const by = ARROWS[event.key];
    if (!by) return;
    event.preventDefault();
    const at = buttons.findIndex((button) => button.dataset.key === chosen());
    choose(buttons[(at + by + buttons.length) % buttons.length].dataset.key);
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
