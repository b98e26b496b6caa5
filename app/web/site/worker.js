/** The worker: all inference of a page without a server. */

import { Desk } from "./desk.js";
import { FOREST } from "./forest.js";
import { Models } from "./models.js";
import { FILES, warm } from "./pictures.js";
import { Refused } from "./refusal.js";
import { QUESTIONS } from "./routes.js";
import { promptly } from "./runtime.js";

const FAILED = "Something went wrong in this browser; the console has the details. Try again, or choose another pair.";
const desks = new Map();
const withdrawn = new Set();

function deskOf(base, set) {
  const told = (loading) => postMessage({ loading });
  if (!desks.has(set)) desks.set(set, new Desk(new Models(new URL(base), set, told)));
  return desks.get(set);
}

async function reply({ id, base, set, path, query, body }) {
  const desk = deskOf(base, set);
  const stopped = () => withdrawn.has(id);
  const question = QUESTIONS[path];
  const patient = path === "warm" ? warm : FOREST[path];
  if (patient) return patient(desk, JSON.parse(body), stopped);
  if (question) return promptly(() => question(desk, JSON.parse(body), stopped));
  const asked = { body: new Uint8Array(body), query: new URLSearchParams(query), stopped };
  return promptly(() => FILES[path](desk, asked));
}

self.onmessage = async ({ data }) => {
  const { id } = data;
  if (data.withdrawn) return withdrawn.add(id);
  try {
    const value = await reply(data);
    postMessage({ id, status: 200, value });
  } catch (error) {
    if (!(error instanceof Refused)) console.error(error);
    const [sentence, status] = error instanceof Refused ? [error.message, error.status] : [FAILED, 500];
    postMessage({ id, status, value: { error: sentence } });
  } finally {
    withdrawn.delete(id);
  }
};
