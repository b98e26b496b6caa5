/** The worker: all inference of a page without a server. */

import { Desk } from "./desk.js";
import { FOREST } from "./forest.js";
import { PICTURES } from "./pictures.js";
import { Refused } from "./refusal.js";
import { QUESTIONS } from "./routes.js";
import { promptly } from "./runtime.js";

const FAILED = "Something went wrong in this browser; the console has the details. Try again, or choose another pair.";
const ROUTES = { ...QUESTIONS, ...PICTURES, ...FOREST };
const PATIENT = ["warm", ...Object.keys(FOREST)];
/** @type {Map<string, Desk>} */
const desks = new Map();
/** @type {Set<number>} */
const withdrawn = new Set();

self.onmessage = async ({ data }) => {
  const { id, base, set, path, query, body } = data;
  if (data.withdrawn) return withdrawn.add(id);
  try {
    const desk = desks.get(set) ?? new Desk(base, set, (loading) => postMessage({ loading }));
    desks.set(set, desk);
    const question = typeof body === "string" ? JSON.parse(body) : Object.fromEntries(new URLSearchParams(query));
    const sent = { body: new Uint8Array(body), stopped: () => withdrawn.has(id) };
    const work = () => ROUTES[path](desk, question, sent);
    postMessage({ id, status: 200, value: await (PATIENT.includes(path) ? work() : promptly(work)) });
  } catch (error) {
    if (!(error instanceof Refused)) console.error(error);
    const [sentence, status] = error instanceof Refused ? [error.message, error.status] : [FAILED, 500];
    postMessage({ id, status, value: { error: sentence } });
  } finally {
    withdrawn.delete(id);
  }
};
