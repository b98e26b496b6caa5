/** What to say where no head fits the set: why, what to do about it, and the command. */

import { fit } from "./facts.js";
import { html, put } from "./text.js";

/** Return the remedy: a sentence, and the command. @param {Fit} fit */
export const remedyHtml = ({ remedy, command }) => html`<p>${remedy}</p><pre tabindex="0">${command}</pre>`;

/** If no head fits the set, say so in place of a tab that needs one. Returns whether it does. @param {Found} root */
export async function needsHead(root) {
  const found = await fit().catch(() => null);
  if (!found?.problem) return false;
  put(
    root.querySelector(".ov"),
    html`<section class="panel headless"><h2>This tab needs a head that fits the set</h2><p>${found.problem}</p>
      ${remedyHtml(found)}<p class="hint"><a href="?set=sensors">The project’s own set</a> has one.</p></section>`,
  );
  return true;
}
