/** What the browser remembers. One that keeps nothing remembers it as long as the page. */

const here = new Map();

/** The text kept under a key; null if there is none. */
export function kept(key) {
  try {
    return localStorage.getItem(key);
  } catch {
    return here.get(key) ?? null;
  }
}

export function keep(key, text) {
  try {
    localStorage.setItem(key, text);
  } catch {
    here.set(key, text);
  }
}

/** What is kept as JSON; `otherwise` if there is nothing that can be read. */
export function keptJson(key, otherwise) {
  try {
    return JSON.parse(kept(key)) ?? otherwise;
  } catch {
    return otherwise;
  }
}
