/** A page without a server: where its requests go instead, to files beside the page or to the worker. */

const block = globalThis.document?.querySelector("#omnivat-held")?.textContent;

/** {files: request -> address of a file, home: the page's own set, sets, refused: request -> sentence, alone: the
 * sentence for what needs a server, local: the script of the worker, models}; null if there is a server. */
export const held = block ? JSON.parse(block) : null;

/** Where the server's paths begin. */
export const base = new URL("omnivat/", document.baseURI);

/** The set in the page's address: one of the project's, or one that the visitor loaded; "" is the server's. */
export const own = new URLSearchParams(location.search).get("set") ?? "";

/** A request in parts: the set, the name of the route, the other parameters in their order. */
function parts(path) {
  const url = new URL(path, base);
  const query = url.searchParams;
  const set = query.get("set") || own || held.home;
  query.delete("set");
  query.sort();
  return { set, path: decodeURIComponent(url.pathname.slice(base.pathname.length)), query };
}

/** The name of a request in `files`; the profile of a visitor's sensor changes no answer that is a file. */
function keyOf({ set, path, query }, body) {
  const { profile, ...question } = body ? JSON.parse(body) : {};
  return `${set}/${path}${query.size ? `?${query}` : ""}${body ? ` ${JSON.stringify(question)}` : ""}`;
}

/** The address of a file for a path; undefined if there is none. */
export const fileOf = (path, body = "") => held.files[keyOf(parts(path), body)];

/** `models`: settled once the models are there that an own pair needs, if they are on their way; maps and familiarity wait for it. */
/** @type {{models: Promise<void> | null}} */
export const line = { models: null };

const failure = (sentence, status) => new Response(JSON.stringify({ error: sentence }), { status });

/** The response to a request, as the server would give it.
 * @param {string} path @param {{body?: any, signal?: AbortSignal}} options */
export async function respond(path, { body, signal } = {}) {
  const asked = parts(path);
  const key = body instanceof Blob ? "" : keyOf(asked, body);
  if (["frames", "familiar"].includes(asked.path)) await line.models;
  if (held.files[key]) return fetch(held.files[key], { signal });
  if (held.refused?.[key]) return failure(held.refused[key], 400);
  if (held.sets && !held.sets.includes(asked.set))
    return failure("These pages do not hold the set of this address.", 410);
  if (!held.local) return failure(held.alone, 501);
  const local = await import(held.local);
  if (!local.ROUTES.has(asked.path)) return failure(held.alone, 501);
  return local.respond({ ...asked, body, signal, models: held.models });
}
