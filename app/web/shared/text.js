/** Escape any text for HTML. */

const CODES = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;" };
export const escaped = (text) => String(text).replace(/[&<>"']/g, (c) => CODES[c]);
/** Markup that may be written into the page: `html` alone makes it. */
export class Html {
  /** @param {string} text */
  constructor(text) {
    this.text = text;
  }
  toString() {
    return this.text;
  }
}
/** @param {unknown} value @returns {string} */
const markup = (value) =>
  value instanceof Html
    ? value.text
    : Array.isArray(value)
      ? value.map(markup).join("")
      : value === null || value === undefined || value === false
        ? ""
        : escaped(value);
/** Markup from a template. Every value in it is escaped, but for markup and lists of markup; null and false are left out.
 * @param {TemplateStringsArray} parts @param {...unknown} values */
export const html = (parts, ...values) =>
  new Html(parts.map((part, at) => (at ? markup(values[at - 1]) : "") + part).join(""));
/** Write markup into an element: the one place of the page that does.
 * @param {Element} box @param {Html} content */
export const put = (box, content) => {
  if (!(content instanceof Html))
    throw new TypeError("put takes markup made by html`…`, so that every value is escaped.");
  box.innerHTML = content.text;
};

/** The HTML of each one, in a row. */
export const each = (all, html) => [...all].map(html).join("");
export const percent = (share, digits = 0) => `${(100 * share).toFixed(digits)}\u00a0%`;
/** True for a set of signals, drawn as stripes: a pair is two recordings of one signal. */
export const isSignals = ({ encoder }) => encoder === "strip";
export const isSimulated = (name) => name.endsWith("-sim");

export const NO_CLASS = "unlabelled"; // the class of a pair without one

/** Options of a choice: [[value, label], …]. */
export const options = (all, chosen = "") =>
  each(
    all,
    ([value, label]) =>
      `<option value="${escaped(value)}"${value === chosen ? " selected" : ""}>${escaped(label)}</option>`,
  );

/** A table that scrolls in its place: headings of the columns, and rows as HTML. */
export const table = (label, head, rows, kind = "") =>
  `<div class="scroll" tabindex="0" role="group" aria-label="${label}"><table class="${kind}"><thead><tr>${each(head, (one) => `<th scope="col">${one}</th>`)}</tr></thead><tbody>${rows.join("")}</tbody></table></div>`;

/** A row of a table: its heading, then its cells. */
export const row = (heading, cells) =>
  `<tr><th scope="row">${heading}</th>${each(cells, (one) => (/^<td/.test(one) ? one : `<td>${one}</td>`))}</tr>`;

/** The bytes of a base64 text. */
export const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

/** Bytes as a base64 text. */
export function base64(bytes) {
  let text = "";
  for (let at = 0; at < bytes.length; at += 32768) text += String.fromCharCode(...bytes.subarray(at, at + 32768));
  return btoa(text);
}

const shown = new WeakMap();
/** What follows once an element was filled; set by what marks terms. @type {{next: (box: HTMLElement) => any}} */
export const filled = { next: () => {} };
/** Write HTML into an element if it is not there yet, so that what is in use keeps the focus. */
export function fill(box, html) {
  if (shown.get(box) === html) return false;
  shown.set(box, html);
  box.innerHTML = html;
  filled.next(box);
  return true;
}
