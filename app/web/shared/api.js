/** Requests to the server. Every failure becomes a Refusal with a one-sentence message. */

import { base, fileOf, held, own, respond } from "./held.js";
import { awaited } from "./ready.js";

/** An error for the visitor; any other error is a bug and stays one. */
export class Refusal extends Error {
  constructor(sentence, status = 0) {
    super(sentence);
    this.status = status;
  }
}

/** Pass the sentence of a Refusal to `say`, or write it into that element; rethrow bugs, ignore cancelled requests. */
export function refused(error, say) {
  if (isCancelled(error)) return;
  if (!(error instanceof Refusal)) throw error;
  if (typeof say === "function") say(error.message);
  else say.textContent = error.message;
}

/** Do something; if it is refused, `say` gets the sentence. */
export async function attempt(act, say) {
  try {
    return await act();
  } catch (error) {
    return refused(error, say);
  }
}

const LOST = "The server does not respond. Is it still running? The page continues when it is back.";
const OTHER = "The server was restarted with another head or set. Reload the page to see it.";

/** The address of a server path; a page without a server has files for some of them. */
export function address(path) {
  if (held) return fileOf(path) ?? "";
  const url = new URL(path, base);
  if (own && !url.searchParams.has("set")) url.searchParams.set("set", own);
  return url.href;
}

/** A path of another set than the page's own. */
export const inSet = (path, set) => (set ? `${path}${path.includes("?") ? "&" : "?"}set=${set}` : path);

const holds = new Map(); // address of a set -> what the server held of it at first

async function checked(request, set) {
  let response;
  try {
    response = await request;
  } catch (error) {
    if (isCancelled(error)) throw error;
    throw new Refusal(LOST);
  }
  const now = response.headers.get("X-Holds");
  if (now && holds.has(set) && now !== holds.get(set)) throw new Refusal(OTHER, 409);
  if (now) holds.set(set, now);
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
  const sent = held ? respond(path, options) : fetch(address(path), options);
  return checked(sent, new URL(path, base).searchParams.get("set") ?? own);
}

const inJson = async (reply) => (await reply).json();
export const json = (path) => awaited(inJson(get(path)));

const kept = new Map();

/** The promise called `name`, made once; after a failure the next call tries again. */
export function once(name, make) {
  if (!kept.has(name)) {
    const made = make().catch((error) => {
      kept.delete(name);
      throw error;
    });
    kept.set(name, made);
  }
  return kept.get(name);
}

const files = new Map(); // reference -> uploaded file, to send again to a restarted server
/** Whether the server has lost what a request was about. */
export const isForgotten = (error) => error instanceof Refusal && error.status === 410;
/** Whether a request was cancelled. */
export const isCancelled = (error) => error instanceof Error && error.name === "AbortError";

/** The profile of this visitor's sensor, which predictions follow; `renew` sends it to a server that has lost it;
 * `head` reads the visitor's own pictures, "" is the first one. */
export const visit = { profile: "", head: "", renew: async () => false };
const READ = new Set(["pair", "many", "attention", "familiar", "teach", "curve", "taught", "save/head"]); // by that head

/** The head that reads the pictures of a question, or learns from its lessons: another one only if all are own.
 * @param {any} question */
export function readerOf({ lessons = [], pairs = [], vis, tac }) {
  const refs = (lessons.length ? lessons : [{ vis, tac }, ...pairs]).flatMap((one) =>
    [one.vis ?? [], one.tac ?? []].flat(),
  );
  return refs.length && refs.every((ref) => ref.startsWith("image:")) ? visit.head : "";
}

/** A question with the visitor's profile, and with the head that reads it. */
function whole(path, question) {
  const head = READ.has(path) ? readerOf(question) : "";
  return { ...(visit.profile && { profile: visit.profile }), ...(head && { head }), ...question };
}

/** Send a request; if the server has lost an uploaded image or the profile, send that again first. */
export const ask = (path, question, signal) => awaited(answered(path, question, signal));

async function answered(path, question, signal) {
  const headers = { "Content-Type": "application/json" };
  const send = async () => {
    const body = JSON.stringify(whole(path, question));
    return inJson(get(path, { method: "POST", body, headers, signal }));
  };
  try {
    return await send();
  } catch (error) {
    const pairs = [question, ...(question.lessons ?? []), ...(question.pairs ?? [])];
    const lost = [...new Set(pairs.flatMap(({ vis, tac }) => [vis, tac]))].filter((ref) => files.has(ref));
    if (!isForgotten(error)) throw error;
    await Promise.all(lost.map((ref) => sendImage(...files.get(ref))));
    if (!(visit.profile && (await visit.renew())) && !lost.length) throw error;
    return send();
  }
}

export async function sendImage(blob, name, signal) {
  const path = `image?name=${encodeURIComponent(name)}`;
  const sent = await awaited(inJson(get(path, { method: "POST", body: blob, signal })));
  files.set(sent.ref, [blob, name]);
  return sent;
}

/** The bytes of a referenced image; null if only the server has it. */
export async function bytesOf(ref, modality) {
  if (files.has(ref)) return files.get(ref)[0];
  if (!ref.startsWith("example:")) return null;
  const path = ref.slice("example:".length).split("/").map(encodeURIComponent).join("/");
  return awaited(get(`example/${path}/${modality}`).then((response) => response.blob()));
}

/** Send an image with a request: "occlusion" or "live"; `taught` names a taught head. */
export async function askOfImage(
  what,
  blob,
  { modality, other = null, order = null, taught = "", split = 0, head = "" },
) {
  const query = new URLSearchParams({ modality });
  if (Number.isFinite(order)) query.set("order", String(order));
  if (other) query.set("other", other);
  if (split) query.set("split", String(split));
  if (taught) query.set("taught", taught);
  if (head) query.set("head", head);
  if (visit.profile) query.set("profile", visit.profile);
  return awaited(inJson(get(`${what}?${query}`, { method: "POST", body: blob })));
}

/** A file that the server makes of a question. Throws a Refusal. */
export function made(path, question) {
  const headers = { "Content-Type": "application/json" };
  const reply = get(path, { method: "POST", body: JSON.stringify(whole(path, question)), headers });
  return awaited(reply.then((response) => response.blob()));
}

/** Upload one file of a head or set; returns its name for `loadParts`. */
export async function sendPart(name, file) {
  return (await awaited(inJson(get(`part?name=${encodeURIComponent(name)}`, { method: "POST", body: file })))).part;
}
