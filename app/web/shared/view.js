/** A view: an element of the page and what is in it. */

export class View {
  constructor(box) {
    this.box = box;
  }

  /** The first part that fits a selector.
   * @returns {any} */
  $(selector) {
    return this.box.querySelector(selector);
  }
}

/** Say something in the element that a view waits with; "" hides it. */
export function tell(wait, sentence, problem = false) {
  wait.textContent = sentence;
  wait.hidden = !sentence;
  wait.classList.toggle("problem", problem);
}

/** What to say while the server makes maps. */
export const making = (step) =>
  step?.total ? `Computing maps, ${step.done} of ${step.total}. Pair works meanwhile.` : "Computing the map…";

/** Handle the clicks in a box: selector -> what a click in such an element does. */
export function onClick(box, acts) {
  box.onclick = ({ target }) => {
    for (const [selector, act] of Object.entries(acts)) {
      const found = target.closest(selector);
      if (found && box.contains(found)) act(found);
    }
  };
}

/** Mark a button as pressed or not. */
export const press = (button, on) => button.setAttribute("aria-pressed", String(Boolean(on)));
