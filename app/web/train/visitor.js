/** This visitor's name and last training, in this browser, so that reloading loses neither. */

import { keptJson, kept as read, keep as write } from "../shared/memory.js";

const NAME = "omnivat-visitor";
const TRAINING = "omnivat-training";

/** A name, so that the server allows one training for each visitor. */
export function visitor() {
  const made = read(NAME) ?? [...crypto.getRandomValues(new Uint32Array(4))].map((n) => n.toString(36)).join("");
  write(NAME, made);
  return made;
}

/** Keep the training {started, question}; null forgets it. */
export const keep = (training) => write(TRAINING, JSON.stringify(training));

/** The kept training, or null. */
export const kept = () => keptJson(TRAINING, null);
