import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import test from "node:test";

const WEB = new URL("../../app/web/", import.meta.url);
const read = (place) => readFileSync(new URL(place, WEB), "utf8");
/** Scripts of the page; those of the page without a server stand in for the server, which knows its rows. */
const SCRIPTS = readdirSync(WEB, { recursive: true }).filter((one) => /^(?!site).*\.js$/.test(one));
const FILTERS = ["domain", "class", "modality"]; // names of filters, too

/** The lines of the scripts that a pattern finds, each with its file. */
const found = (pattern, scripts = SCRIPTS.map((name) => [name, read(name)])) =>
  scripts.flatMap(([name, text]) =>
    text
      .split("\n")
      .filter((line) => pattern.test(line))
      .map((line) => `${name}: ${line.trim()}`),
  );

const rows = Object.values(JSON.parse(read("shared/tables.json"))).flat();
const rungs = [...read("../../omnivat/measure/rungs.py").matchAll(/"?id"?[:=] ?"(\w+)"/g)].map(([, id]) => id);
const ids = [...rows.map(({ id }) => id), ...rungs].filter((id) => !FILTERS.includes(id)).join("|");
const named = `["'\`](${ids}|[nkm]\\d+)["'\`]`;
const COMPARED = new RegExp(`([=!]==|case) ?${named}|${named}\\)? [=!]==|${named}[^\\]]*\\]\\.includes`);
const WRITTEN = /\b(state|scene)\.\w+(\.\w+)* (\?\?|\|\||&&|[-+*/])?= |Object\.assign\((state|scene)\b/;

test("no script asks a mode, measure, step, rung, colour or method for its name", () => {
  assert.ok(rungs.includes("spread") && SCRIPTS.length > 80);
  assert.deepEqual(found(COMPARED), []);
  for (const line of ['stage !== "raw"', 'if (rung === "mean")', '["mean", "spread"].includes(rung)', 'case "every":'])
    assert.equal(found(COMPARED, [["made.js", line]]).length, 1, line);
});

test("no script writes into the state but by its events", () => {
  assert.deepEqual(found(WRITTEN), []);
  for (const line of ["state.p ??= learned;", "scene.frames.columns = {};", "Object.assign(scene, patch)"])
    assert.equal(found(WRITTEN, [["made.js", line]]).length, 1, line);
});
