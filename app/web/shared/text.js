/** Text and markup. */

/** @type {Record<string, string>} */
const CODES = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;" };
/** @param {unknown} text */
const escaped = (text) => String(text).replace(/[&<>"']/g, (c) => CODES[c]);
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
/** @type {WeakMap<TemplateStringsArray, string[]>} */
const templates = new WeakMap();
/** Return the texts of a template without its line breaks, as in JSX: one between words or in a tag is a space, one
 * beside a tag or a value is nothing.
 * @param {TemplateStringsArray} parts */
function unbroken(parts) {
  let tag = false;
  return parts.map((part) =>
    part.replace(/[<>]|\s*\n\s*/g, (found, at) => {
      if (found === "<" || found === ">") tag = found === "<";
      const [before, after] = [part[at - 1], part[at + found.length]];
      if (found.trim()) return found;
      return tag || (before && before !== ">" && after && after !== "<") ? " " : "";
    }),
  );
}
/** Markup from a template. Every value in it is escaped, but for markup and lists of markup; null and false are left
 * out.
 * @param {TemplateStringsArray} parts @param {...unknown} values */
export const html = (parts, ...values) => {
  const texts = templates.get(parts) ?? unbroken(parts);
  templates.set(parts, texts);
  return new Html(texts.map((text, at) => (at ? markup(values[at - 1]) : "") + text).join(""));
};
/** Write markup into an element: the one place of the page that does.
 * @param {Element} box @param {Html} content */
export const put = (box, content) => {
  if (!(content instanceof Html))
    throw new TypeError("put takes markup made by html`…`, so that every value is escaped.");
  box.innerHTML = content.text;
};

/** @param {number} share */
export const percent = (share, digits = 0) => `${(100 * share).toFixed(digits)}\u00a0%`;
/** Return a number with its thousands apart. @param {number} n */
export const grouped = (n) => n.toLocaleString("en-US");
/** @param {number} low @param {number} high */
export const interval = (low, high) => `95 % interval: ${percent(low)} to ${percent(high)}`;
/** Return words between which something stands; what is absent is left out. @param {unknown[]} words */
export const joined = (words, between = ", ") => words.filter(Boolean).join(between);
/** @param {string} name */
export const isSimulated = (name) => name.endsWith("-sim");

export const NO_CLASS = "unlabelled"; // the class of a pair without one

/** Options of a choice: [[value, label], …].
 * @param {(string | number)[][]} all @param {string | number} chosen */
export const options = (all, chosen = "") =>
  html`${all.map(
    ([value, label]) => html`<option value="${value}"${value === chosen && html` selected`}>${label}</option>`,
  )}`;

/** Return a table that scrolls in its place: headings of the columns, and its rows.
 * @param {string} label @param {Markup[]} head @param {Markup[]} rows */
export const table = (label, head, rows) =>
  html`<div class="scroll" tabindex="0" role="group" aria-label="${label}"><table><thead><tr>${head.map(
    (column) => html`<th scope="col">${column}</th>`,
  )}</tr></thead><tbody>${rows}</tbody></table></div>`;

/** Return a row of a table: its heading, then its cells, as <td> or as what is in one.
 * @param {Markup} heading @param {Markup[]} cells */
export const row = (heading, cells) =>
  html`<tr><th scope="row">${heading}</th>${cells.map((cell) =>
    cell instanceof Html && cell.text.startsWith("<td") ? cell : html`<td>${cell}</td>`,
  )}</tr>`;

/** Return the bytes of a base64 text. @param {string} text */
export const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

/** Bytes as a base64 text. @param {Uint8Array} bytes */
export function base64(bytes) {
  let text = "";
  for (let at = 0; at < bytes.length; at += 32768) text += String.fromCharCode(...bytes.subarray(at, at + 32768));
  return btoa(text);
}

/** @type {WeakMap<Element, string>} */
const shown = new WeakMap();

/** Draw what is in an element: what is alike stays, so that focus, typed text, open details and transitions do.
 * Returns whether anything changed. @param {Element} box @param {Html} content */
export function draw(box, content) {
  if (shown.get(box) === content.text) return false;
  shown.set(box, content.text);
  const wanted = document.createElement("template");
  put(wanted, content);
  follow(box, wanted.content);
  return true;
}

/** Make a box's nodes like the wanted ones, and leave those that are alike. @param {Node} box @param {Node} wanted */
function follow(box, wanted) {
  const [old, made] = [box, wanted].map((parent) => [...parent.childNodes]);
  made.forEach((node, i) => {
    const there = old[i];
    if (!there) box.appendChild(node);
    else if (!(there instanceof Element && node instanceof Element && there.tagName === node.tagName))
      box.replaceChild(node, there);
    else {
      for (const { name } of [...there.attributes])
        if (name !== "open" && !node.hasAttribute(name)) there.removeAttribute(name);
      for (const { name, value } of node.attributes)
        if (there.getAttribute(name) !== value) there.setAttribute(name, value);
      follow(there, node);
    }
  });
  for (const gone of old.slice(made.length)) box.removeChild(gone);
}

/** What follows once an element was filled; set by what marks terms. @type {{next: (box: Element) => unknown}} */
export const filled = { next: () => {} };
/** Draw what is in an element, with definitions of its terms. @param {Element} box @param {Html} content */
export function fill(box, content) {
  if (draw(box, content)) filled.next(box);
}

/** Return a name for bytes, to tell files of one visitor apart. @param {Uint8Array} bytes */
export function nameOf(bytes) {
  let [a, b] = [0xdeadbeef, 0x41c6ce57];
  for (let at = 0; at < bytes.length; at++) {
    a = Math.imul(a ^ bytes[at], 2654435761);
    b = Math.imul(b ^ bytes[at], 1597334677);
  }
  return [a, b, bytes.length].map((part) => (part >>> 0).toString(16).padStart(8, "0")).join("");
}
