/** What the server predicts for pairs, and replies that may be refused. */

import { ask, Refusal, unread } from "../shared/api.js";
import { batches } from "./parts.js";
import { said } from "./verdict.js";

/** A reply, or why it was refused. @template Reply @param {Promise<Reply>} asking
 * @returns {Promise<Reply | {problem: string}>} */
export const quietly = (asking) =>
  asking.catch((error) => {
    if (!(error instanceof Refusal)) throw error;
    return { problem: error.message };
  });

/** Pairs with what is predicted for exactly them, or why nothing is: by the head as trained, or by what lessons teach.
 * @template {Pair} Some @param {Some[]} pairs @param {{lessons?: Lesson[]}} [lessons] @param {AbortSignal} [signal]
 * @returns {Promise<(Some & {said?: any, problem?: string})[]>} */
export async function predicted(pairs, lessons, signal) {
  const all = [];
  for (const some of batches(pairs, PAIRS_AT_ONCE, ({ vis, tac }) => unread(vis) + unread(tac))) {
    const questions = some.map(({ vis, tac }) => ({ vis, tac }));
    const { classes, pairs: answers } = await ask("many", { pairs: questions, ...lessons }, signal);
    for (const [i, pair] of some.entries()) {
      const { readings, problem } = answers[i];
      all.push({ ...pair, ...answers[i], ...(problem ? {} : { classes, said: said(classes, readings) }) });
    }
  }
  return all;
}

/** A labelled pair for the count. @param {Lesson & {name: string}} pair */
export async function counted(pair) {
  const [one] = await predicted([pair]);
  if (one.problem) throw new Refusal(one.problem);
  return /** @type {OwnPair} */ (one);
}

const PAIRS_AT_ONCE = 12; // of one request
let last = { lessons: "", taught: "" }; // a handle of the server's: nothing of it is drawn
/** The name of the head that lessons teach; "" without lessons. `fresh` to teach again if the server may have dropped
 * the head. @param {{lessons?: Lesson[]}} of @param {boolean} fresh */
export async function taughtBy({ lessons }, fresh) {
  if (!lessons) return "";
  const key = JSON.stringify(lessons);
  if (fresh || last.lessons !== key) last = { lessons: key, taught: (await ask("taught", { lessons })).taught };
  return last.taught;
}
