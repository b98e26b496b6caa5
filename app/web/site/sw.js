/** Keeps the pages for visits without a network. Files are named by content, so a kept one never is old. */

const worker = /** @type {any} */ (globalThis);
const { first, rest } = worker.omnivatSite; // addresses of files, relative to this one
const scope = worker.registration.scope;
const NAME = `omnivat ${scope}`; // other pages of this host have theirs
const known = new Set([...first, ...rest].map((file) => new URL(file, scope).href));
const PAUSE = 200; // milliseconds
// They let the page use several threads; everything here is of one origin.
const ALONE = {
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Embedder-Policy": "require-corp",
  "Cross-Origin-Resource-Policy": "same-origin",
};

function alone(response) {
  if (!response.status || response.redirected) return response;
  const headers = new Headers(response.headers);
  for (const [name, value] of Object.entries(ALONE)) headers.set(name, value);
  return new Response(response.body, { status: response.status, statusText: response.statusText, headers });
}

let wanted = 0; // files on their way to the page, before which copies for later visits wait

async function kept(request) {
  const cache = await caches.open(NAME);
  const there = await cache.match(request.url);
  if (there) return alone(there);
  wanted += 1;
  try {
    const response = await fetch(request.url);
    if (response.ok) await cache.put(request.url, response.clone());
    return alone(response);
  } finally {
    wanted -= 1;
  }
}

/** The page itself: from the network, else as it was last. */
async function page(request) {
  const cache = await caches.open(NAME);
  try {
    const response = await fetch(request);
    if (response.ok) await cache.put(scope, response.clone());
    return alone(response);
  } catch (error) {
    const there = await cache.match(scope);
    if (there) return alone(there);
    throw error;
  }
}

async function clear() {
  const cache = await caches.open(NAME);
  for (const { url } of await cache.keys()) if (url !== scope && !known.has(url)) await cache.delete(url);
  await worker.clients.claim();
}

async function keep(files) {
  const cache = await caches.open(NAME);
  for (const file of files) {
    while (wanted) await new Promise((resolve) => setTimeout(resolve, PAUSE));
    if (!(await cache.match(new URL(file, scope)))) await cache.add(new URL(file, scope));
  }
}

worker.addEventListener("install", (event) => event.waitUntil(keep(["./", ...first]).then(() => worker.skipWaiting())));
worker.addEventListener("activate", (event) => event.waitUntil(clear()));
worker.addEventListener("message", (event) => event.data === "keep" && event.waitUntil(keep(rest)));
worker.addEventListener("fetch", (event) => {
  const { request } = event;
  if (request.method !== "GET") return;
  if (known.has(request.url)) event.respondWith(kept(request));
  else if ([scope, `${scope}index.html`].includes(request.url.split(/[?#]/)[0])) event.respondWith(page(request));
});
