/** Real pairs of others, which the owner of the server has fetched: with their terms, and read like dropped
 * pictures. */

import { address } from "../shared/api.js";
import { button, hint, html, imagesOf, pressed } from "./parts.js";
import { framed, pictured } from "./slots.js";

/** Title without its subtitle. @param {RealSet} set */
export const short = ({ title }) => title.split(/[:,]/)[0];

/** What stands with a picture: its authors in short, its terms, what was changed. @param {RealSet} set */
export function credit({ authors, licence, terms, changes }) {
  const [first, ...others] = authors.split(", ");
  const by = others.length ? `${first} and ${others.length} others` : first;
  const changed = changes === "none" ? "" : `; changed: ${changes}`;
  return `by ${by}, ${licence.split(", ")[0] || terms || "no terms stated"}${changed}`;
}

/** The shelf; null where a server can have none. @param {PairTab} tab */
export function realHtml({ real, ...tab }) {
  if (!real || (!real.local && !real.sets.length && !real.left_out.length)) return null;
  const command = html`This server has no real pairs. Run <code>python -m omnivat fetch touch-and-go</code> in its
    folder, and reload the page.`;
  const lines = real.left_out.map(hint);
  const none = real.local && !real.sets.length && !lines.length && hint(command);
  return html`<h3>Real</h3>${real.sets.map((set, k) => setHtml(tab, set, k))}${lines}${none}`;
}

/** @param {Omit<PairTab, "real">} tab @param {RealSet} set @param {number} k */
function setHtml(tab, set, k) {
  const [name, link] = set.licence.split(", ");
  const terms = link
    ? html`<a href="${link}" target="_blank" rel="noreferrer">${name}</a>`
    : `Terms: ${set.terms || "none stated"} (${set.terms_from})`;
  const changes = set.changes !== "none" && ` Changed: ${set.changes}.`;
  const count = set.pairs.length < set.count && ` ${set.pairs.length} of ${set.count.toLocaleString()} pairs.`;
  const pairs = set.pairs.map(({ pictures, class: words }, i) => {
    const key = `${k}/${i}`;
    const label = `${words}, ${short(set)}`;
    const open = [tab.vis, tab.tac].includes(tab.reals[key] ?? "");
    return button(
      "fetch",
      framed(
        imagesOf(pictures).map((one) => pictured(address(`real/${pictures[one]}`))),
        words,
      ),
      html`data-key="${key}" title="${label}, ${credit(set)}" aria-label="${label}" ${pressed(open)}
        ${tab.doing.fetch === key && html` aria-busy="true"`}`,
    );
  });
  return html`<figure><figcaption class="hint"><b>${set.title}</b>, by ${set.authors}. ${terms}.${changes}
    ${count}</figcaption>
    <div class="gallery" tabindex="0" role="group" aria-label="Pairs of ${short(set)}">${pairs}</div></figure>`;
}
