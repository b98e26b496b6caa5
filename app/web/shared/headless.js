/** What to say where no head fits the set: why, what to do about it, and the command. */

import { fit } from "./facts.js";
import { escaped } from "./text.js";

/** The remedy as HTML: a sentence, a command, and the tab that trains. @param {any} found */
export const remedyHtml = ({ remedy, command }) =>
  `<p>${escaped(remedy)}</p><pre tabindex="0">${escaped(command)}</pre>`;

/** If no head fits the set, say so in place of a tab that needs one. Returns whether it does. */
export async function needsHead(root) {
  const found = await fit().catch(() => ({ problem: "" }));
  if (!found.problem) return false;
  root.querySelector(".ov").innerHTML =
    `<section class="panel headless"><h2>This tab needs a head that fits the set</h2><p>${escaped(found.problem)}</p>${remedyHtml(found)}<p class="hint"><a href="?set=sensors">The project’s own set</a> has one.</p></section>`;
  return true;
}
