/** A view: an element of the page and its content. */

export class View {
  /** @param {Found} box */
  constructor(box) {
    this.box = box;
  }

  /** The first part that fits a selector. @param {string} selector @returns {Found} */
  $(selector) {
    return this.box.querySelector(selector);
  }
}

/** Say something in the element that a view waits with; "" hides it.
 * @param {Found} wait @param {string} sentence */
export function tell(wait, sentence, problem = false) {
  wait.textContent = sentence;
  wait.hidden = !sentence;
  wait.classList.toggle("problem", problem);
}

/** Return what to say while the server makes maps. @param {Step | null} step */
export const making = (step) => {
  const far = step?.total
    ? `Drawing map ${step.done} of ${step.total}`
    : step?.text && `Drawing the maps: ${step.text}`;
  return far ? `${far}. Try a pair can be used meanwhile.` : "Drawing the map…";
};

/** Handle the clicks in a box. `acts`: selector -> the action for a click in such an element.
 * @param {Found} box @param {Record<string, (element: Found) => unknown>} acts */
export function onClick(box, acts) {
  box.onclick = (/** @type {Found} */ { target }) => {
    for (const [selector, act] of Object.entries(acts)) {
      const element = target.closest(selector);
      if (element && box.contains(element)) act(element);
    }
  };
}

/** Mark a button as pressed or not. @param {Found} button @param {unknown} on */
export const press = (button, on) => button.setAttribute("aria-pressed", String(Boolean(on)));
