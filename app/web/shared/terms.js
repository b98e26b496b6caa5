/** Definitions where the words stand: point at a word of the field, tap it or go there by Tab. */

import { json, once } from "./api.js";
import { filled } from "./text.js";

const QUIET = new Set("class label pair photo touch noise cosine style guess reading p".split(" "));
const OFF = "button, summary, select, textarea, pre, code, svg, dfn, h1, [data-term], [role=radio], .definition";
// the text that a definition leaves free
const AROUND = "p, li, dd, h2, h3, h4, legend, figcaption, td, th, label, button";
const ROOM = 8; // CSS pixels between a text and its definition

/** Word of the page -> its sentence, and a pattern of the words that are marked. */
const table = () =>
  once("terms", async () => {
    /** @type {Map<string, string>} */
    const terms = new Map();
    for (const [term, sentence] of Object.entries(await json("glossary")))
      for (const word of term.split(/ \(|\)/)) if (word) terms.set(word, `${term.split(" (")[0]}: ${sentence}.`);
    const words = [...terms.keys()]
      .filter((word) => !QUIET.has(word))
      .sort((a, b) => b.length - a.length)
      .map((word) => word.replace(/^[a-z]/, (first) => `[${first}${first.toUpperCase()}]`)); // OF is no "of"
    return { terms, pattern: new RegExp(`(?<![\\p{L}\\p{M}])(${words.join("|")})(s?)(?![\\p{L}\\p{M}])`, "u") };
  });

/** Mark the first use of each term in the text of an element. @param {Element} box */
async function define(box) {
  const known = await table().catch(() => null);
  if (!known || box.querySelector("dfn")) return;
  const seen = new Set();
  const walker = document.createTreeWalker(box, NodeFilter.SHOW_TEXT);
  /** @type {Text[]} */
  const texts = [];
  while (walker.nextNode()) texts.push(/** @type {Text} */ (walker.currentNode));
  for (const text of texts) {
    const match = !text.parentElement?.closest(OFF) && known.pattern.exec(text.data);
    if (!match) continue;
    const word = text.splitText(match.index);
    texts.push(word.splitText(match[0].length)); // more terms may follow
    const term = known.terms.has(match[1]) ? match[1] : match[1].toLowerCase();
    if (seen.has(term)) continue;
    seen.add(term);
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
  /** @param {{target: Found}} event */
  const show = async ({ target }) => {
    /** @type {HTMLElement | null} */
    const mark = target.closest?.("[data-term]") ?? null;
    if (mark === at) return;
    at?.removeAttribute("aria-describedby");
    at = mark;
    box.hidden = true;
    const known = mark && (await table().catch(() => null));
    const sentence = known?.terms.get(mark?.dataset.term ?? "");
    if (!mark || !sentence || at !== mark) return;
    box.textContent = sentence;
    box.hidden = false;
    mark.setAttribute("aria-describedby", box.id);
    const text = (mark.closest(AROUND) ?? mark).getBoundingClientRect();
    const { width, height } = box.getBoundingClientRect();
    const below = text.bottom + ROOM + height < innerHeight;
    box.style.top = `${below ? text.bottom + ROOM : Math.max(0, text.top - ROOM - height)}px`;
    box.style.left = `${Math.max(ROOM, Math.min(innerWidth - width - ROOM, mark.getBoundingClientRect().left))}px`;
  };
  const away = () => show({ target: document.body });
  for (const kind of ["pointerover", "focusin", "click"]) document.addEventListener(kind, show);
  document.addEventListener("keydown", ({ key }) => key === "Escape" && away());
  document.addEventListener("scroll", away, { capture: true, passive: true });
}
