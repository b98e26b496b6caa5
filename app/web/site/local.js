/** The page's side of the worker: a request of Try a pair in, a Response as the server's out. */

import { held, own } from "../shared/held.js";
import { placed } from "./places.js";

/** The routes that the browser computes; what else needs a server. */
export const ROUTES = new Set([
  ...["pair", "many", "attention", "familiar", "profile", "teach", "taught"],
  ...["image", "live", "occlusion", "sensor", "save/sensor"],
  ...["tree", "place", "neighbours"],
]);
const DEAD = "The models cannot be started in this browser; reload the page, or open it in another one.";

/** @type {Worker | null} */
let worker = null;
let last = 0;
const waiting = new Map(); // number of a request -> {resolve, reject}
const coming = new Map(); // what is on its way -> megabytes of it

/** Show what is being fetched, until it is there. */
function loading({ text, done, total }) {
  const known = total >= done; // a compressed file is longer than its header says
  if (known && done === total) coming.delete(text);
  else coming.set(text, `${text}, ${(done / 1e6).toFixed(1)}${known ? ` of ${(total / 1e6).toFixed(1)}` : ""} MB`);
  /** @type {HTMLElement | null} */
  let note = document.querySelector(".on-its-way");
  if (!note) {
    note = document.createElement("p");
    note.className = "ov on-its-way";
    note.setAttribute("role", "status");
    document.body.append(note);
  }
  note.hidden = !coming.size;
  note.textContent = `Once for this browser: ${[...coming.values()].join("; ")}`;
}

function started() {
  if (worker) return worker;
  const made = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  made.onmessage = ({ data }) => {
    if (data.loading) return loading(data.loading);
    waiting.get(data.id)?.resolve(data);
    waiting.delete(data.id);
  };
  made.onerror = () => {
    for (const [id, { resolve }] of waiting) resolve({ id, status: 503, value: { error: DEAD } });
    waiting.clear();
    worker = null;
  };
  return (worker = made);
}

function sent(message, signal) {
  return new Promise((resolve, reject) => {
    signal?.throwIfAborted();
    const id = ++last;
    waiting.set(id, { resolve, reject });
    signal?.addEventListener("abort", () => {
      if (!waiting.delete(id)) return;
      worker?.postMessage({ id, withdrawn: true });
      reject(signal.reason);
    });
    started().postMessage({ id, ...message });
  });
}

const addressOf = (models) => new URL(models.endsWith("/") ? models : `${models}/`, document.baseURI).href;

/** Fetch and start what a first own pair needs; settled once it is there, or cannot be had. */
export async function prepare() {
  if (/** @type {any} */ (navigator).connection?.saveData) return;
  const { home, models } = /** @type {Held} */ (held);
  await sent({ base: addressOf(models), set: own || home, path: "warm", query: "", body: "{}" });
}

/** Respond to a request: `set` and `path` by name, `query` of the address, `body` text or a Blob; `models`:
 * the address of the models. */
export async function respond({ set, path, query, body, signal, models }) {
  const base = addressOf(models);
  const content = body instanceof Blob ? await body.arrayBuffer() : (body ?? "{}");
  const ask = (name, asked) => sent({ base, set, path: name, query: `${query}`, body: asked }, signal);
  const { status, value } = path === "place" ? await placed(set, content, ask) : await ask(path, content);
  if (value instanceof Uint8Array) return new Response(/** @type {any} */ (value), { status });
  return new Response(JSON.stringify(value), { status, headers: { "Content-Type": "application/json" } });
}
