/** onnxruntime-web, where the browser can run it. */

import { Refusal } from "../shared/refusal.js";

// a module whose function has one SIMD instruction
const SIMD = Uint8Array.from(atob("AGFzbQEAAAABBQFgAAF7AwIBAAoKAQgAQQD9D/1iCw=="), (one) => one.charCodeAt(0));
const MOST_THREADS = 4;
const OLD =
  "This browser has no WebAssembly with SIMD, which the models need, or it is switched off; " +
  "use one from 2023 or later.";
export const LOST = "A file of this page did not arrive; check the connection and try again.";

/** Start the runtime; throws a Refusal where this browser cannot run it.
 * @param {string | URL} base @param {(url: URL, title: string) => Promise<ArrayBuffer>} bytes */
async function start(base, bytes) {
  if (!globalThis.WebAssembly?.validate(SIMD)) throw new Refusal(OLD);
  const [ort, program] = await Promise.all([
    import(new URL("runtime/ort.wasm.bundle.min.mjs", base).href).catch(() => {
      throw new Refusal(LOST);
    }),
    bytes(new URL("runtime/ort-wasm-simd-threaded.wasm", base), "the program that computes"),
  ]);
  ort.env.wasm.numThreads = self.crossOriginIsolated ? Math.min(MOST_THREADS, navigator.hardwareConcurrency ?? 1) : 1;
  ort.env.wasm.wasmBinary = program;
  return ort;
}

/** @type {Promise<any> | null} */
let started = null;
/** Return the runtime from the folder of the models; a Refusal where it cannot run, and the next call tries again.
 * @param {string | URL} base @param {(url: URL, title: string) => Promise<ArrayBuffer>} bytes fetches a file */
export function runtime(base, bytes) {
  started ??= start(base, bytes).catch((error) => {
    started = null;
    throw error;
  });
  return started;
}

/** @type {Promise<unknown>} */
let turn = Promise.resolve();
/** Do `work` after all that came before: the runtime has one stack, which two calls at once would break.
 * @template T @param {() => Promise<T>} work @returns {Promise<T>} */
export function inTurn(work) {
  const done = turn.then(work);
  turn = done.catch(() => {});
  return done;
}

let prompt = 0; // questions that a visitor waits for
/** Do `work`, for which the long walks over a set wait.
 * @template T @param {() => Promise<T>} work @returns {Promise<T>} */
export async function promptly(work) {
  prompt += 1;
  try {
    return await work();
  } finally {
    prompt -= 1;
  }
}

/** Let other messages in, and settle once no visitor waits. */
export async function quiet() {
  do await new Promise((resolve) => setTimeout(resolve));
  while (prompt);
}
