/** The page's side of the worker: a request of Try a pair in, a Response as the server's out. */

import { held, own } from "../shared/held.js";

/** The routes that the browser computes; what else needs a server. */
export const ROUTES = new Set(["pair", "attention", "familiar", "tree", "journey", "neighbours"]);
const DEAD = "The models cannot be started in this browser; reload the page, or open it in another one.";

/** @type {Worker | null} */
let worker = null;
/** @type {Map<string, string>} */
const coming = new Map(); // what is on its way -> megabytes of it

/** Show what is being fetched, until it is there. @param {{ data: Step }} message */
function loading({ data: { text, done, total } }) {
  const known = total >= done; // a compressed file is longer than its header states
  if (known && done === total) coming.delete(text);
  else coming.set(text, `${text}, ${(done / 1e6).toFixed(1)}${known ? ` of ${(total / 1e6).toFixed(1)}` : ""} MB`);
  const note = /** @type {HTMLElement | null} */ (document.querySelector(".on-its-way"));
  if (!note) return;
  note.hidden = !coming.size;
  note.textContent = `Once for this browser: ${[...coming.values()].join("; ")}`;
}

/** Send a message to the worker; return its reply.
 * @param {Record<string, any>} message @param {AbortSignal | null} [signal]
 * @returns {Promise<{ status: number, value: any }>} */
function sent(message, signal) {
  return new Promise((resolve, reject) => {
    signal?.throwIfAborted();
    worker ??= new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    worker.onmessage = loading;
    const { port1: port, port2 } = new MessageChannel();
    port.onmessage = ({ data }) => resolve(data);
    worker.addEventListener("error", () => {
      resolve({ status: 503, value: { error: DEAD } });
      worker = null;
    });
    signal?.addEventListener("abort", () => {
      port.postMessage("withdrawn");
      reject(signal.reason);
    });
    worker.postMessage(message, [port2]);
  });
}

/** @param {string} models */
const addressOf = (models) => new URL(models.endsWith("/") ? models : `${models}/`, document.baseURI).href;

/** Fetch and start what a first own pair needs; settled once it is there, or cannot be had. */
export async function prepare() {
  if (/** @type {any} */ (navigator).connection?.saveData) return;
  const { home, models } = /** @type {Held} */ (held);
  await sent({ base: addressOf(models ?? ""), set: own || home, path: "warm", body: "{}" });
}

/** Respond to a request: `set` and `path` by name, `query` of the address, `body` text or a Blob; `models`: the address
 * of the models.
 * @param {Record<"set" | "path" | "models", string> & {query: URLSearchParams, body?: any,
 *   signal?: AbortSignal | null}} request */
export async function respond({ set, path, query, body, signal, models }) {
  const content = body instanceof Blob ? await body.arrayBuffer() : (body ?? "{}");
  const { status, value } = await sent(
    { base: addressOf(models), set, path, query: `${query}`, body: content },
    signal,
  );
  return Response.json(value, { status });
}
