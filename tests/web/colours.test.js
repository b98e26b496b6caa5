/** Colours of points: by domain, class or a column of the pairs' table. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { can, TABLES } from "../../app/web/shared/tables.js";
import { frames } from "./browser.js";

TABLES.colours.push({ id: "kind", title: "Class", column: "kind" }); // before the colourings are made
const { colouring, colouringsOf } = await import("../../app/web/shared/palette.js");

const of = (...kind) => frames({ columns: { kind } });

test("a column has a colour for each of its values, and is offered only if they differ", () => {
  const shown = of("worn", "");
  const { id, groups, of: group } = colouring(shown, "kind");
  assert.equal(id, "kind");
  assert.deepEqual(
    groups(shown).map(([name]) => name),
    ["none", "worn"],
  );
  assert.deepEqual([0, 1].map(group(shown, 0)), [1, 0]);
  for (const none of [of("new", "new"), of(), frames()]) assert.equal(colouring(none, "kind").id, "class");
});

test("of a column with more values than colours, the most frequent have one each and the others share one", () => {
  const names = [..."abcdefghij"];
  const shown = of(...names, "j", "i");
  const { groups, of: group } = colouring(shown, "kind");
  const [keys, colours] = [0, 1].map((part) => groups(shown).map((one) => one[part]));
  assert.deepEqual(keys, ["a", "b", "c", "d", "e", "i", "j", "3 other values"]);
  assert.equal(new Set(colours).size, 8);
  assert.deepEqual([0, 9, 10, 5].map(group(shown, 0)), [0, 6, 6, 7]);
});

test("colours that follow the prediction change with p, and those of the pairs do not", () => {
  const moving = colouringsOf(of("new", "worn")).flatMap((row) => (can(row, "order") ? [row.id] : []));
  assert.deepEqual(moving, ["correctness", "confidence"]);
});
