/** The worker: all inference of a page without a server. */

import { Refusal } from "../shared/refusal.js";
import { Desk } from "./desk.js";
import { FOREST } from "./forest.js";
import { JOURNEY } from "./journey.js";
import { READING } from "./routes.js";
import { promptly } from "./runtime.js";

const FAILED = "Something went wrong in this browser; the console has the details. Try again, or choose another pair.";
const ROUTES = { ...READING, ...FOREST, ...JOURNEY };
const PATIENT = ["warm", ...Object.keys(FOREST)];
/** @type {Map<string, Desk>} */
const desks = new Map();

self.onmessage = async ({ data, ports: [port] }) => {
  const { base, set, path, query, body } = data;
  let stopped = false;
  port.onmessage = () => (stopped = true);
  try {
    const desk = desks.get(set) ?? new Desk(base, set, (loading) => postMessage(loading));
    desks.set(set, desk);
    const sizes = (new URLSearchParams(query).get("sizes") ?? "").split(",");
    let at = 0;
    const parts = sizes.map((size) => new Uint8Array(body.slice(at, (at += Number(size)))));
    const text = typeof body === "string" ? body : new TextDecoder().decode(parts.shift());
    const files = typeof body === "string" ? [] : parts;
    const route = (/** @type {any} */ question) => ROUTES[path](desk, question, { stopped: () => stopped });
    const work = () => desk.withPictures(JSON.parse(text), files, route);
    port.postMessage({ status: 200, value: await (PATIENT.includes(path) ? work() : promptly(work)) });
  } catch (error) {
    if (!(error instanceof Refusal)) console.error(error);
    const [sentence, status] = error instanceof Refusal ? [error.message, error.status || 400] : [FAILED, 500];
    port.postMessage({ status, value: { error: sentence } });
  }
};
