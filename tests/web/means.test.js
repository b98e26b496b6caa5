/** The source's label on a map: it covers as little as possible. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";

const { labelPlaces } = await import("../../app/web/shared/means.js");

const WIDE = 44;
const VIEW = [200, 300];
const box = ([x, y]) => [x - WIDE / 2, y - 10, x + WIDE / 2, y + 2];
const apart = (a, b) => a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
const mark = ([x, y]) => [x - 8, y - 8, x + 8, y + 8];

test("a label stands above its point if nothing is there", () => {
  const [[x, y]] = labelPlaces([[100, 150]], [[100, 150]], WIDE, VIEW);
  assert.equal(x, 100);
  assert.ok(y < 150);
});

test("labels cover no mark, no other label and no axis name, and stay on the map", () => {
  const marks = [
    [100, 150],
    [100, 130],
    [150, 155],
    [30, 30],
  ];
  const found = labelPlaces([marks[0], marks[2], marks[3]], marks, WIDE, VIEW).map(box);
  found.forEach((one, i) => {
    assert.ok(one[0] >= 0 && one[1] >= 22 && one[2] <= VIEW[0]);
    for (const other of marks) assert.ok(apart(one, mark(other)), `label ${i} on ${other}`);
    for (const other of found.slice(i + 1)) assert.ok(apart(one, other));
  });
});

test("two means closer than a label have one label", () => {
  const close = [
    [100, 150],
    [110, 160],
  ];
  assert.equal(labelPlaces(close, close, WIDE, VIEW).length, 1);
});
