/** This visitor's name and last training, in this browser, so that reloading loses neither. */

const NAME = "omnivat-visitor";
const TRAINING = "omnivat-training";
const memory = new Map(); // in a frame of another site, a browser may refuse its storage

function read(key) {
  try {
    return localStorage.getItem(key);
  } catch {
    return memory.get(key) ?? null;
  }
}

function write(key, text) {
  try {
    localStorage.setItem(key, text);
  } catch {
    memory.set(key, text);
  }
}

/** A name, so that the server allows one training for each visitor. */
export function visitor() {
  const made =
    read(NAME) ?? [...crypto.getRandomValues(new Uint32Array(4))].map((n) => n.toString(36)).join("");
  write(NAME, made);
  return made;
}

/** Keep the training {started, question}; null forgets it. */
export const keep = (training) => write(TRAINING, JSON.stringify(training));

/** The kept training, or null. */
export function kept() {
  try {
    return JSON.parse(read(TRAINING) ?? "null");
  } catch {
    return null;
  }
}
