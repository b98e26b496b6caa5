/** This visitor's name and last training, in this browser, so that reloading loses neither. */

const NAME = "omnivat-visitor";
const TRAINING = "omnivat-training";

/** A name, so that the server allows one training for each visitor. */
export function visitor() {
  const made =
    localStorage.getItem(NAME) ??
    [...crypto.getRandomValues(new Uint32Array(4))].map((n) => n.toString(36)).join("");
  localStorage.setItem(NAME, made);
  return made;
}

/** Keep the training {started, question}; null forgets it. */
export function keep(training) {
  if (training) localStorage.setItem(TRAINING, JSON.stringify(training));
  else localStorage.removeItem(TRAINING);
}

/** The kept training, or null. */
export function kept() {
  try {
    return JSON.parse(localStorage.getItem(TRAINING) ?? "null");
  } catch {
    return null;
  }
}
