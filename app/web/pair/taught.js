/** The name of the head that the visitor's pairs taught, for requests whose body is an image. */

import { ask } from "../shared/api.js";

let last = { lessons: "", taught: "" };

/** "" without lessons; `fresh` to teach again if the server may have dropped the head.
 * @param {{lessons?: object[]}} own */
export async function taughtBy({ lessons }, fresh = true) {
  if (!lessons) return "";
  const key = JSON.stringify(lessons);
  if (fresh || last.lessons !== key) last = { lessons: key, taught: (await ask("taught", { lessons })).taught };
  return last.taught;
}
