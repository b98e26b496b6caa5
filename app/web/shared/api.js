/** Requests to the server. Every failure becomes a Refusal with a one-sentence message. */

/** An error for the visitor; any other error is a bug and stays one. */
export class Refusal extends Error {
  constructor(sentence, status = 0) {
    super(sentence);
    this.status = status;
  }
}

/** Pass the sentence of a Refusal to `say`; rethrow bugs, ignore cancelled requests. */
export function refused(error, say) {
  if (error.name === "AbortError") return;
  if (!(error instanceof Refusal)) throw error;
  say(error.message);
}

const ALONE = "This page is a single file without a server, so this does not work here.";
const LOST = "The server does not respond. Is it still running? The page continues when it is back.";
const OTHER = "The server was restarted with another head or set. Reload the page to see it.";
const base = new URL("omnivat/", document.baseURI);

const desk = new URLSearchParams(location.search).get("set"); // a head or set loaded by this visitor
const held = globalThis.omnivatHeld; // the data inside a page saved as one file

/** The address of a server path; a saved page contains some of them. */
export function address(path) {
  if (held?.[path]) return held[path];
  const url = new URL(path, base);
  if (desk) url.searchParams.set("set", desk);
  return url.href;
}

let holds = null; // the head and set of this page

async function checked(request) {
  let response;
  try {
    response = await request;
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refusal(LOST);
  }
  const now = response.headers.get("X-Holds");
  if (now && holds && now !== holds) throw new Refusal(OTHER, 409);
  holds ??= now;
  if (response.ok) return response;
  let sentence = `The server refused (${response.status}).`;
  try {
    sentence = (await response.json()).error || sentence;
  } catch {
    /* not our server's JSON: the status has to do */
  }
  throw new Refusal(sentence, response.status);
}

export async function get(path, options) {
  if (held && !held[path]) throw new Refusal(ALONE, 404);
  return checked(fetch(address(path), options));
}

export const json = async (path) => (await get(path)).json();

const files = new Map(); // reference -> uploaded file, to send again to a restarted server
const FORGOTTEN = 410;

/** Send a request; if the server has lost an uploaded image, upload it again first. */
export async function ask(path, question, signal) {
  const body = JSON.stringify(question);
  const headers = { "Content-Type": "application/json" };
  const send = async () => (await get(path, { method: "POST", body, headers, signal })).json();
  try {
    return await send();
  } catch (error) {
    const pairs = [question, ...(question.lessons ?? [])];
    const lost = [...new Set(pairs.flatMap(({ vis, tac }) => [vis, tac]))].filter((ref) => files.has(ref));
    if (error.status !== FORGOTTEN || !lost.length) throw error;
    await Promise.all(lost.map((ref) => sendImage(...files.get(ref))));
    return send();
  }
}

export async function sendImage(blob, name) {
  const path = `image?name=${encodeURIComponent(name)}`;
  const sent = await (await get(path, { method: "POST", body: blob })).json();
  files.set(sent.ref, [blob, name]);
  return sent;
}

/** The bytes of a referenced image; null if only the server has it. */
export async function bytesOf(ref, modality) {
  if (files.has(ref)) return files.get(ref)[0];
  if (!ref.startsWith("example:")) return null;
  const path = ref.slice("example:".length).split("/").map(encodeURIComponent).join("/");
  return (await get(`example/${path}/${modality}`)).blob();
}

/** Send an image with a request: "occlusion" or "live"; `taught` names a taught head. */
export async function askOfImage(what, blob, { modality, other, order, taught = "" }) {
  const query = new URLSearchParams({ modality });
  if (Number.isFinite(order)) query.set("order", order);
  if (other) query.set("other", other);
  if (taught) query.set("taught", taught);
  return (await get(`${what}?${query}`, { method: "POST", body: blob })).json();
}

/** Upload one file of a head or set; returns its name for `loadParts`. */
export async function sendPart(name, file) {
  return (await (await get(`part?name=${encodeURIComponent(name)}`, { method: "POST", body: file })).json())
    .part;
}
