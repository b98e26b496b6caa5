/** Texts that the browser keeps for good, or for this visit. If storage is blocked, they last as long as the page. */

/** @type {Map<string, string | null>} */
const here = new Map();
/** @param {boolean} visit */
const storage = (visit) => (visit ? sessionStorage : localStorage);

/** Return the text kept under a key; null if there is none. @param {string} key */
export function kept(key, visit = false) {
  try {
    return storage(visit).getItem(key);
  } catch {
    return here.get(key) ?? null;
  }
}

/** Keep a text; null forgets it. @param {string} key @param {string | null} text */
export function keep(key, text, visit = false) {
  try {
    if (text === null) storage(visit).removeItem(key);
    else storage(visit).setItem(key, text);
  } catch {
    here.set(key, text);
  }
}

/** Return what is kept as JSON; `otherwise` if there is nothing that can be read.
 * @param {string} key @param {unknown} otherwise @returns {any} */
export function keptJson(key, otherwise, visit = false) {
  try {
    return JSON.parse(kept(key, visit) ?? "null") ?? otherwise;
  } catch {
    return otherwise;
  }
}
