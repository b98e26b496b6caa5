/** Names on a map: none covers another. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { apart, settled } from "../../app/web/shared/means.js";

const VIEW = [300, 200];
const label = (x, y) => ({ text: "a", x, y, wide: 60 });
const far = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
const covers = (a, b) => Math.abs(a.x - b.x) < (a.wide + b.wide) / 2 && Math.abs(a.y - b.y) < 22;

test("names cover no other name and stay on the map, and one alone at its mean", () => {
  const { x, y } = apart([label(100, 150)], VIEW)[0];
  assert.deepEqual([x, y], [100, 150]);
  const found = apart([label(100, 60), label(104, 62), label(98, 58), label(2, 3), label(299, 199)], VIEW);
  found.forEach((one, i) => {
    assert.ok(one.x >= 30 && one.x <= 270 && one.y >= 11 && one.y <= 189);
    for (const other of found.slice(i + 1)) assert.ok(!covers(one, other));
  });
});

test("a name whose mean lies between two clouds stands in one of them", () => {
  const spots = [
    [20, 20],
    [21, 22],
    [19, 21],
    [180, 160],
    [181, 161],
    [178, 159],
    [60, 150],
    [62, 149],
  ];
  const count = spots.length;
  const cloud = {
    count: 2 * count, // photos alone are shown
    width: 200,
    height: 200,
    x: Float32Array.from([...spots, ...spots], ([x]) => x),
    y: Float32Array.from([...spots, ...spots], ([, y]) => y),
  };
  const groups = [{ both: [100, 91] }, { both: [61, 149.5] }, { both: 0 }];
  const found = settled(
    groups,
    (pair) => Number(pair > 5),
    cloud,
    (point) => point < count,
  );
  assert.ok(Math.min(...spots.slice(0, 6).map((spot) => far(spot, [found[0].x, found[0].y]))) < 3);
  assert.deepEqual([found[1].x, found[1].y], [61, 149.5]);
  assert.equal(found[2].both, 0);
});

test("points of a larger set before, which have no group yet, count for no name", () => {
  const cloud = { count: 8, width: 300, height: 200, x: [10, 12, 90, 99, 11, 9, 91, 99], y: [5, 6, 9, 9, 5, 6, 9, 9] };
  const of = (/** @type {number} */ pair) => [0, 0][pair]; // two pairs are known, the cloud has four
  const [{ x, y }] = settled([{ both: [10, 5] }], of, cloud, () => true);
  assert.deepEqual([x, y], [10.5, 5.5]);
});
