/** Questions to the server. Every failure becomes a Refusal whose message is one sentence. */

/** Something that a person is told; any other error is a fault of a script and stays one. */
export class Refusal extends Error {}

/** Tell `say` the sentence of a refusal; let faults, and questions called off, pass. */
export function refused(error, say) {
  if (error.name === "AbortError") return;
  if (!(error instanceof Refusal)) throw error;
  say(error.message);
}

const LOST = "The server does not answer. Is it still running? The page goes on when it is back.";
const base = new URL("omnivat/", document.baseURI);

export const address = (path) => new URL(path, base).href;

async function answered(request) {
  let response;
  try {
    response = await request;
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refusal(LOST);
  }
  if (response.ok) return response;
  let sentence = `The server refused (${response.status}).`;
  try {
    sentence = (await response.json()).error || sentence;
  } catch { /* not our server's JSON: the status has to do */ }
  throw new Refusal(sentence);
}

export const get = (path, options) => answered(fetch(address(path), options));

export const json = async (path) => (await get(path)).json();

export async function ask(path, question, signal) {
  const body = JSON.stringify(question);
  const headers = { "Content-Type": "application/json" };
  return (await get(path, { method: "POST", body, headers, signal })).json();
}

export async function sendImage(blob, name) {
  const path = `image?name=${encodeURIComponent(name)}`;
  return (await get(path, { method: "POST", body: blob })).json();
}
