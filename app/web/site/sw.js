/** Keeps the pages for visits without a network. Files are named by content, so a kept one never is old. */

const worker = /** @type {any} */ (globalThis);
const { first, rest } = worker.omnivatSite; // addresses of files, relative to this one
const scope = worker.registration.scope;
const NAME = `omnivat ${scope}`; // other pages of this host have theirs
const address = (/** @type {string} */ file) => new URL(file, scope).href;
const known = new Set([...first, ...rest].map(address));
const PAUSE = 200; // milliseconds
// They let the page use several threads; everything here is of one origin.
const ALONE = {
  "cross-origin-opener-policy": "same-origin",
  "cross-origin-embedder-policy": "require-corp",
  "cross-origin-resource-policy": "same-origin",
};

/** @param {Response} response */
function alone(response) {
  if (!response.status || response.redirected) return response;
  const { status, statusText } = response;
  const headers = { ...Object.fromEntries(response.headers), ...ALONE };
  return new Response(response.body, { status, statusText, headers });
}

let wanted = 0; // files on their way to the page, before which copies for later visits wait

/** Return a file as it is kept; the page itself, whose name stays, from the network, else as it was last.
 * @param {Request} request */
async function served(request) {
  const own = !known.has(request.url);
  const cache = await caches.open(NAME);
  const kept = await cache.match(own ? scope : request.url);
  if (kept && !own) return alone(kept);
  wanted += 1;
  try {
    const response = await fetch(own ? request : request.url);
    if (response.ok) await cache.put(own ? scope : request.url, response.clone());
    return alone(response);
  } catch (error) {
    if (kept) return alone(kept);
    throw error;
  } finally {
    wanted -= 1;
  }
}

async function clear() {
  const cache = await caches.open(NAME);
  for (const { url } of await cache.keys()) if (url !== scope && !known.has(url)) await cache.delete(url);
  await worker.clients.claim();
}

/** Keep files for a visit without a network, one after another, while nothing else is wanted.
 * @param {string[]} files */
async function keep(files) {
  const cache = await caches.open(NAME);
  for (const file of files.map(address)) {
    while (wanted) await new Promise((resolve) => setTimeout(resolve, PAUSE));
    if (!(await cache.match(file))) await cache.add(file);
  }
}

worker.oninstall = (/** @type {any} */ event) =>
  event.waitUntil(keep(["./", ...first]).then(() => worker.skipWaiting()));
worker.onactivate = (/** @type {any} */ event) => event.waitUntil(clear());
worker.onmessage = (/** @type {any} */ event) => event.data === "keep" && event.waitUntil(keep(rest));
worker.onfetch = (/** @type {any} */ event) => {
  const { url, method } = event.request;
  const page = [scope, `${scope}index.html`].includes(url.split(/[?#]/)[0]);
  if (method === "GET" && (page || known.has(url))) event.respondWith(served(event.request));
};
