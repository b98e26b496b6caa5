/** Download a file. */

import { get } from "./api.js";
import { awaited } from "./ready.js";

/** @param {string} name @param {Blob | string} what a text is a table */
export function save(name, what) {
  const blob = typeof what === "string" ? new Blob([what], { type: "text/csv" }) : what;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** The file that the server makes of a question. Throws a Refusal. */
export function made(path, question) {
  const headers = { "Content-Type": "application/json" };
  const reply = get(path, { method: "POST", body: JSON.stringify(question), headers });
  return awaited(reply.then((response) => response.blob()));
}
