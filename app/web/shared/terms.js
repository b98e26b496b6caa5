/** Definitions where the words stand: point at a word of the field, tap it or go there by Tab. */

import { json, once } from "./api.js";
import { filled } from "./text.js";

const QUIET = new Set("class label pair photo touch noise cosine style guess reading p".split(" "));
const OFF = "button, summary, select, textarea, pre, code, svg, dfn, h1, [data-term], [role=radio], .definition";
const ROOM = 8; // CSS pixels between a text and its definition

/** Word of the page -> its sentence. */
const table = () =>
  once("terms", async () => {
    const found = new Map();
    for (const [term, sentence] of Object.entries(await json("glossary"))) {
      const [name, short] = term.split(/ \(|\)/);
      for (const word of [name, short]) if (word) found.set(word, `${name}: ${sentence}.`);
    }
    return found;
  });

const known = (terms) => {
  const words = [...terms.keys()]
    .filter((word) => !QUIET.has(word))
    .sort((a, b) => b.length - a.length)
    .map((word) => word.replace(/^[a-z]/, (first) => `[${first}${first.toUpperCase()}]`)); // OF is no "of"
  return new RegExp(`(?<![\\p{L}\\p{M}])(${words.join("|")})(s?)(?![\\p{L}\\p{M}])`, "u");
};

/** Mark the first use of each term in the text of an element. */
export async function define(box) {
  const terms = await table().catch(() => null);
  if (!terms || box.querySelector("dfn")) return;
  const pattern = known(terms);
  const seen = new Set();
  const walker = document.createTreeWalker(box, NodeFilter.SHOW_TEXT);
  const texts = [];
  while (walker.nextNode()) texts.push(walker.currentNode);
  for (const text of texts) {
    if (text.parentElement?.closest(OFF)) continue;
    const match = pattern.exec(text.data);
    if (!match) continue;
    const [, found] = match;
    const term = terms.has(found) ? found : found.toLowerCase();
    if (seen.has(term)) {
      texts.push(text.splitText(match.index + match[0].length));
      continue;
    }
    seen.add(term);
    const word = text.splitText(match.index);
    texts.push(word.splitText(match[0].length)); // more terms may follow
    const mark = document.createElement("dfn");
    mark.dataset.term = term;
    mark.tabIndex = 0;
    word.replaceWith(mark);
    mark.append(word);
  }
}

/** Show the definition of the element that is pointed at, tapped or focused; below the text, or above it. */
export function showDefinitions() {
  const box = document.createElement("div");
  box.className = "ov definition";
  box.id = "ov-definition";
  box.setAttribute("role", "tooltip");
  box.hidden = true;
  document.body.append(box);
  filled.next = define;
  /** @type {HTMLElement | null} */
  let at = null;
  const show = async ({ target }) => {
    const mark = target.closest?.("[data-term]") ?? null;
    if (mark === at) return;
    at?.removeAttribute("aria-describedby");
    at = mark;
    box.hidden = true;
    const sentence = mark && (await table().catch(() => null))?.get(mark.dataset.term);
    if (!sentence || at !== mark) return;
    box.textContent = sentence;
    box.hidden = false;
    mark.setAttribute("aria-describedby", box.id);
    const text = (
      mark.closest("p, li, dd, h2, h3, h4, legend, figcaption, td, th, label, button") ?? mark
    ).getBoundingClientRect();
    const { width, height } = box.getBoundingClientRect();
    const below = text.bottom + ROOM + height < innerHeight;
    box.style.top = `${below ? text.bottom + ROOM : Math.max(0, text.top - ROOM - height)}px`;
    box.style.left = `${Math.max(ROOM, Math.min(innerWidth - width - ROOM, mark.getBoundingClientRect().left))}px`;
  };
  for (const kind of ["pointerover", "focusin", "click"]) document.addEventListener(kind, show);
  document.addEventListener("keydown", ({ key }) => key === "Escape" && show({ target: document.body }));
  document.addEventListener("scroll", () => show({ target: document.body }), { capture: true, passive: true });
}
