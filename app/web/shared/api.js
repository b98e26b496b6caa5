/** Requests to the server. Every failure becomes a Refusal with a one-sentence message. */

import { base, fileOf, held, own, respond } from "./held.js";
import { withImages } from "./images.js";
import { keep, keptJson } from "./memory.js";
import { keeper } from "./once.js";
import { awaited } from "./ready.js";
import { Refusal } from "./refusal.js";
import { nameOf } from "./text.js";

export { Refusal };

/** Where a sentence goes: to a function, or into an element. @typedef {((sentence: string) => unknown) | Found} Say */

/** Pass the sentence of a Refusal to `say`, or write it into that element; rethrow bugs, ignore cancelled requests.
 * @param {unknown} error @param {Say} say */
export function refused(error, say) {
  if (isCancelled(error)) return;
  if (!(error instanceof Refusal)) throw error;
  if (typeof say === "function") say(error.message);
  else say.textContent = error.message;
}

/** Do something; if it is refused, `say` gets the sentence.
 * @template T @param {() => T | Promise<T>} act @param {Say} say @returns {Promise<T | undefined>} */
export async function attempt(act, say) {
  try {
    return await act();
  } catch (error) {
    refused(error, say);
  }
}

const CLOSED = "The server closed the connection. Try again.";
const AWAY = "A file of this page did not arrive. Check the connection and try again.";
const LARGE = 200_000; // bytes of a reply that takes seconds on a slow line
const NEWLINE = 10;
const PAUSE = 2000; // milliseconds between two looks whether the server is back
const OTHER = "The server was restarted with another head or set. Reload the page to see it.";

/** Return the address of a server path; a page without a server has files for some of them. @param {string} path */
export function address(path) {
  if (held) return fileOf(held, path) ?? "";
  const url = new URL(path, base);
  if (own && !url.searchParams.has("set")) url.searchParams.set("set", own);
  return url.href;
}

/** Return a path of another set than the page's own; its type stays that of the path, which names the reply.
 * @template {string} Path @param {Path} path @param {string} set */
export const inSet = (path, set) =>
  /** @type {Path} */ (set ? `${path}${path.includes("?") ? "&" : "?"}set=${set}` : path);

/** @type {Map<string, string>} */
const holds = new Map(); // address of a set -> what the server held of it at first

/** Whether the server responds again, after how many looks; one wait serves all requests.
 * @type {Promise<number> | null} */
let returning = null;

/** Wait until the server responds; meanwhile the page's header states that it does not. */
async function waited() {
  const tell = (/** @type {boolean} */ lost) =>
    document.dispatchEvent(new CustomEvent("omnivat:lost", { detail: lost }));
  for (let looks = 0; ; looks++) {
    const there = await fetch(address("glossary"), { cache: "no-store" }).catch(() => null);
    if (there) {
      returning = null;
      tell(false);
      return looks;
    }
    tell(true);
    await new Promise((done) => {
      setTimeout(done, PAUSE);
      addEventListener("online", done, { once: true });
    });
  }
}

/** Return the body of a response. A large one tells its path and the share that has arrived; `begun` gets the first
 * line of one that is sent in lines of JSON, once it is there.
 * @param {Response} response @param {string} path @param {Sent["begun"]} begun */
async function bodyOf(response, path, begun) {
  const total = Number(response.headers.get("Content-Length"));
  const reader = (total > LARGE || begun) && response.body?.getReader();
  if (!reader) return response.blob();
  /** @type {BlobPart[]} */
  const parts = [];
  for (let size = 0; ; ) {
    const { done, value } = await reader.read();
    if (done) return new Blob(parts);
    parts.push(/** @type {BlobPart} */ (value));
    if (begun && value.includes(NEWLINE)) begun(linesIn(await new Blob(parts).text())[0]);
    size += value.length;
    if (!total) continue;
    const detail = { path, share: Math.min(1, size / total) };
    document.dispatchEvent(new CustomEvent("omnivat:arriving", { detail }));
  }
}

/** Send a request to the server, and again once the server is back if the connection is lost. Whoever reads a body
 * while it comes (`whole` is false) sends the request again if it ends midway.
 * @param {string} path @param {Sent} [options] */
async function sent(path, { whole = true, begun, ...options } = {}) {
  for (let again = false; ; again = true) {
    try {
      const response = await fetch(address(path), options);
      // a connection is also lost midway
      return whole ? new Response(await bodyOf(response, path, begun), response) : response;
    } catch (error) {
      if (isCancelled(error)) throw error;
      returning ??= waited();
      const looks = await returning;
      options.signal?.throwIfAborted();
      if (again && !looks) throw new Refusal(CLOSED);
    }
  }
}

/** Return a response that is good and of the set as it was; throw a Refusal for any other.
 * @param {Promise<Response>} request @param {string} set */
async function checked(request, set) {
  const response = await request;
  const now = response.headers.get("X-Holds");
  if (now && (holds.get(set) ?? now) !== now) throw new Refusal(OTHER, 409);
  if (now) holds.set(set, now);
  if (response.ok) return response;
  const { error } = await response.json().catch(() => ({})); // it may not be our server's JSON
  throw new Refusal(error || `The server refused (${response.status}).`, response.status);
}

/** Throw an error as it is if it is a Refusal or a cancelled request, else a Refusal: the server is away.
 * @param {unknown} error @returns {never} */
function unheld(error) {
  throw isCancelled(error) || error instanceof Refusal ? error : new Refusal(AWAY);
}

/** @param {string} text @returns {any[]} */
const linesIn = (text) => text.split("\n").flatMap((line) => (line ? [JSON.parse(line)] : []));

/** @typedef {RequestInit & {whole?: boolean, begun?: (first: any) => void}} Sent */
/** The response to a path. @param {string} path @param {Sent} [options] */
export async function get(path, options) {
  const request = held ? respond(held, path, options).catch(unheld) : sent(path, options);
  return checked(request, new URL(path, base).searchParams.get("set") ?? own);
}

/** Return the response to a question or a file.
 * @param {string} path @param {object | Blob} content
 * @param {AbortSignal} [signal] @param {Sent["begun"]} [begun] */
function post(path, content, signal, begun) {
  const file = content instanceof Blob && content;
  /** @type {HeadersInit} */
  const headers = file ? {} : { "Content-Type": "application/json" };
  return get(path, { method: "POST", body: file || JSON.stringify(content), headers, signal, begun });
}

/** @template Reply @param {Promise<Response>} response @returns {Promise<Reply>} */
const replied = (response) => awaited(response.then((found) => found.json()));

/** @template {string} Path @param {Path} path @returns {Promise<ReplyTo<Path>>} */
export const json = (path) => replied(get(path));

/** Make what the page needs once. */
export const once = keeper();

/** The visitor's pictures: the file, and what it is called. @type {Map<Ref, [content: Blob, name: string]>} */
const files = new Map();
const READ = "omnivat-read"; // of this visit: the last pictures survive a reload
const LAST = 60;
/** What the server read in a picture, in its place from then on, by `keyOf`. @type {Map<string, string>} */
const read = new Map(keptJson(READ, [], true));
const GONE = "This browser no longer has this picture. Choose its file again.";
/** Return the key of what was read in a picture: a touch is read as it is mended, and by the lamps of a profile.
 * @param {Ref} ref @param {string} mend @param {string} lit */
const keyOf = (ref, mend, lit) => `${ref} ${mend} ${lit}`;
/** Return true for a visitor's own picture. @param {unknown} ref @returns {ref is Ref} */
export const isOwnPicture = (ref) => typeof ref === "string" && ref.startsWith("image:");
/** Return the bytes that the next request sends of an image. @param {Ref | null | undefined} ref */
export const unread = (ref) => (ref && !read.has(keyOf(ref, visit.mend, visit.lit)) && files.get(ref)?.[0].size) || 0;

/** Take a picture of the visitor's; the next request about it sends it. @param {Blob} content @param {string} name */
export async function hold(content, name) {
  const ref = `image:${nameOf(new Uint8Array(await content.arrayBuffer()))}`;
  if (!files.has(ref)) files.set(ref, [content, name]);
  return ref;
}

/** Return whether the server has lost what a request was about. @param {unknown} error */
const isForgotten = (error) => error instanceof Refusal && error.status === 410;
/** Return whether a request was cancelled. @param {unknown} error */
const isCancelled = (error) => error instanceof Error && error.name === "AbortError";

/** The profile of this visitor's sensor, which predictions follow; `renew` sends it to a server that has lost it;
 * `head` reads the visitor's own pictures, "" is the first one; `mend` is how their touches are mended first;
 * `lit` is the profile if they are read by its lamps.
 * `seen` gets the sizes of pictures that were read, and small copies.
 * @type {{profile: string, head: string, mend: string, lit: string, renew: () => Promise<boolean>,
 *   seen: (pictures: Record<Ref, {width: number, height: number, preview: string}>) => void}} */
export const visit = { profile: "", head: "", mend: "", lit: "", renew: async () => false, seen: () => {} };
// by that head
const BY_HEAD = new Set("pair many attention occlusion familiar teach curve taught save/head".split(" "));

/** Return the images of a question's pairs. @param {Pictured} question @returns {Ref[]} */
const imagesIn = ({ lessons = [], pairs = [], vis, tac }) =>
  [...lessons, { vis, tac }, ...pairs].flatMap((pair) => [pair.vis ?? [], pair.tac ?? []].flat());

/** Return the head that reads the pictures of a question, or learns from its lessons: another one only if all are own.
 * @param {Pictured} question */
export function readerOf({ lessons = [], ...question }) {
  const refs = imagesIn(lessons.length ? { lessons } : question);
  return refs.length && refs.every((ref) => isOwnPicture(ref)) ? visit.head : "";
}

/** Return a question with the visitor's profile, and with the head that reads it.
 * @param {string} path
 * @param {Question} question */
function whole(path, question) {
  const head = BY_HEAD.has(path) ? readerOf(question) : "";
  const { profile, mend } = visit;
  return { ...(profile && { profile }), ...(mend && { mend }), ...(head && { head }), ...question };
}

/** Return a question as it is sent, with what was read in the visitor's pictures; those that nobody has read yet come
 * after it, or all that are there (`anew`), with what is `attached`.
 * @param {Question} question @param {Blob[]} attached */
function packed({ anew, ...question }, attached) {
  /** @type {Ref[]} */
  const fresh = [];
  const mend = /** @type {string} */ (question.mend ?? "");
  const lit = question.profile === visit.lit ? visit.lit : "";
  const sent = withImages(question, (ref) => {
    const known = isOwnPicture(ref) ? read.get(keyOf(ref, mend, lit)) : ref;
    if (known && !(anew && files.has(ref))) return known;
    if (!files.has(ref)) throw new Refusal(GONE);
    if (!fresh.includes(ref)) fresh.push(ref);
    return `file:${attached.length + fresh.indexOf(ref)}`;
  });
  const own = fresh.map((ref) => /** @type {[Blob, string]} */ (files.get(ref)));
  const blobs = [...attached, ...own.map(([content]) => content)];
  return {
    sent: { ...sent, ...(blobs.length && { names: [...attached.map(() => ""), ...own.map(([, n]) => n)] }) },
    blobs,
    fresh,
    mend,
    lit,
  };
}

/** @param {string} path @param {object} question @param {Blob[]} files @param {AbortSignal} [signal]
 * @param {Sent["begun"]} [begun] */
function withFiles(path, question, files, signal, begun) {
  if (!files.length) return post(path, question, signal, begun);
  const parts = [new Blob([JSON.stringify(question)]), ...files];
  const address = `${path}${path.includes("?") ? "&" : "?"}sizes=${parts.map(({ size }) => size)}`;
  return post(address, new Blob(parts), signal, begun);
}

/** Send a question, and the pictures that come with it; what was read in those is kept.
 * @param {string} path @param {Question} question @param {AbortSignal} [signal] @param {Blob[]} [attached]
 * @param {Sent["begun"]} [begun] */
async function posted(path, question, signal, attached = [], begun = undefined) {
  const { sent, blobs, fresh, mend, lit } = packed(whole(path, question), attached);
  const response = await withFiles(path, sent, blobs, signal, begun);
  if (!blobs.length && !begun) return response;
  const { pictures = [], problem, ...reply } = Object.assign({}, ...linesIn(await response.text()));
  /** @type {string[]} */
  const broken = [];
  /** @type {Parameters<typeof visit.seen>[0]} */
  const seen = {};
  for (const [at, ref] of fresh.entries()) {
    const found = pictures[attached.length + at];
    if (found?.problem) broken.push(found.problem);
    if (!found?.ref) continue;
    read.set(keyOf(ref, mend, lit), found.ref);
    seen[ref] = found;
  }
  visit.seen(seen);
  keep(READ, JSON.stringify([...read].slice(-LAST)), true);
  if (problem) throw new Refusal(problem);
  return Response.json({ ...reply, ...(broken.length && { broken }) });
}

/** Send a request; if the server has lost the profile, send that again first; if another encoder has read its pictures,
 * send those again. `begun` gets what is there first of a reply in two lines.
 * @template {string} Path @param {Path} path @param {Question} question @param {AbortSignal} [signal]
 * @param {Blob[]} [attached] @param {(first: ReplyTo<Path>) => void} [begun] @returns {Promise<ReplyTo<Path>>} */
export const ask = (path, question, signal, attached, begun) =>
  replied(answered(path, question, signal, attached, begun));

/** Send a question; if the server forgot its pictures or profile, send those again with it.
 * @param {string} path @param {Question} question @param {AbortSignal} [signal] @param {Blob[]} [attached]
 * @param {Sent["begun"]} [begun] */
async function answered(path, question, signal, attached, begun) {
  const send = () => posted(path, question, signal, attached, begun);
  try {
    return await send();
  } catch (error) {
    if (!isForgotten(error)) throw error;
    const again = imagesIn(question).filter((ref) => files.has(ref));
    for (const key of [...read.keys()]) if (again.some((ref) => key.startsWith(ref))) read.delete(key);
    if (!(visit.profile && (await visit.renew())) && !again.length) throw error;
    return send();
  }
}

/** Return the bytes of a referenced image; null if only the server has it.
 * @param {Ref} ref @param {Modality} modality @returns {Promise<Blob | null>} */
export async function bytesOf(ref, modality) {
  const sent = files.get(ref);
  if (sent) return sent[0];
  if (!ref.startsWith("example:")) return null;
  const path = ref.slice("example:".length).split("/").map(encodeURIComponent).join("/");
  return awaited(get(`example/${path}/${modality}`).then((response) => response.blob()));
}

/** Return a file that the server makes of a question, whose own pictures are read first, and of what is `attached`.
 * Throws a Refusal.
 * @param {string} path @param {Question} question @param {Blob[]} [attached] */
export async function made(path, question, attached = []) {
  for (const ref of imagesIn(question)) if (unread(ref)) await ask("many", { pairs: [{ tac: ref }] });
  const { sent, blobs } = packed(whole(path, question), attached);
  return awaited(withFiles(path, sent, blobs).then((response) => response.blob()));
}

/** Upload one file of a head or set; its name in `load` is the reply's `part`.
 * @param {string} name @param {Blob} file @returns {Promise<Replies["part"]>} */
export const sendPart = (name, file) => replied(post(`part?name=${encodeURIComponent(name)}`, file));
