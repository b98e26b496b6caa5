/** What the server predicts for pairs, and replies that may be refused. */

import { ask, Refusal } from "../shared/api.js";
import { said } from "./verdict.js";

/** A reply, or why it was refused. @template Reply @param {Promise<Reply>} asking
 * @returns {Promise<Reply | {problem: string}>} */
export const quietly = (asking) =>
  asking.catch((error) => {
    if (!(error instanceof Refusal)) throw error;
    return { problem: error.message };
  });

/** Pairs with what is predicted for exactly them: by the head as trained, or by what lessons teach.
 * @template {Pair} Some @param {Some[]} pairs @param {{lessons?: Lesson[]}} [lessons] @param {AbortSignal} [signal] */
export async function predicted(pairs, lessons, signal) {
  const questions = pairs.map(({ vis, tac }) => ({ vis, tac }));
  const { classes, pairs: answers } = await ask("many", { pairs: questions, ...lessons }, signal);
  return pairs.map((pair, i) => ({ ...pair, ...answers[i], classes, said: said(classes, answers[i].readings) }));
}

/** A labelled pair for the count. @param {Lesson & {name: string}} pair */
export const counted = async (pair) => (await predicted([pair]))[0];

let last = { lessons: "", taught: "" }; // a handle of the server's: nothing of it is drawn
/** The name of the head that lessons teach; "" without lessons. `fresh` to teach again if the server may have dropped
 * the head. @param {{lessons?: Lesson[]}} of */
export async function taughtBy({ lessons }, fresh = true) {
  if (!lessons) return "";
  const key = JSON.stringify(lessons);
  if (fresh || last.lessons !== key) last = { lessons: key, taught: (await ask("taught", { lessons })).taught };
  return last.taught;
}
