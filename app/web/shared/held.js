/** A page without a server: where its requests go instead, to files beside the page or to the worker. */

const block = globalThis.document?.querySelector("#omnivat-held")?.textContent;

/** What this page has instead of a server; null if there is one. @type {Held | null} */
export const held = block ? JSON.parse(block) : null;

/** Where the server's paths begin. */
export const base = new URL("omnivat/", document.baseURI);

/** The set in the page's address: one of the project's, or one that the visitor loaded; "" is the server's. */
export const own = new URLSearchParams(location.search).get("set") ?? "";

/** Return a request in parts: the set, the name of the route, the other parameters in their order; and its name in
 * `files`, where the profile of a visitor's sensor changes no answer.
 * @param {Held} page @param {string} path @param {string} body */
function parts({ home }, path, body = "") {
  const url = new URL(path, base);
  const query = url.searchParams;
  const set = query.get("set") || own || home;
  query.delete("set");
  query.sort();
  const route = decodeURIComponent(url.pathname.slice(base.pathname.length));
  const { profile, ...question } = body ? JSON.parse(body) : {};
  const key = `${set}/${route}${query.size ? `?${query}` : ""}${body ? ` ${JSON.stringify(question)}` : ""}`;
  return { set, path: route, query, key };
}

/** Return the address of a file for a path; undefined if there is none. @param {Held} page @param {string} path */
export const fileOf = (page, path) => page.files[parts(page, path).key];

/** `models`: settled once the models are there that an own pair needs, if they are on their way; maps wait for it. */
/** @type {{models: Promise<void> | null}} */
export const line = { models: null };

/** @param {string} sentence @param {number} status */
const failure = (sentence, status) => new Response(JSON.stringify({ error: sentence }), { status });

/** Return the response to a request, as the server would give it.
 * @param {Held} page @param {string} path @param {RequestInit} options @returns {Promise<Response>} */
export async function respond(page, path, { body, signal } = {}) {
  const { key, ...request } = parts(page, path, typeof body === "string" ? body : "");
  if (request.path === "frames") await line.models;
  if (page.files[key]) return fetch(page.files[key], { signal });
  if (page.refused?.[key]) return failure(page.refused[key], 400);
  if (page.sets && !page.sets.includes(request.set))
    return failure("These pages do not hold the set of this address.", 410);
  if (!page.local) return failure(page.alone, 501);
  const local = await import(page.local);
  if (!local.ROUTES.has(request.path)) return failure(page.alone, 501);
  return local.respond({ ...request, body, signal, models: page.models });
}
