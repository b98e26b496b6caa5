import { equal } from "node:assert/strict";
import { test } from "node:test";
import { Scale } from "../../app/web/shared/chart.js";

const PAD = { left: 10, right: 30, top: 5, bottom: 15 };
const scale = new Scale({ wide: 140, high: 60, pad: PAD, xs: [2, 4], ys: [-1, 3] });

for (const [value, x, y] of [
  [[2, -1], 10, 45],
  [[4, 3], 110, 5],
  [[2.5, 0], 35, 35],
]) {
  test(`${value} lies ${x} pixels from the left and ${y} from the top`, () => {
    equal(scale.x(value[0]), x);
    equal(scale.y(value[1]), y);
  });
}

test("a line has a gap where there is no value, and an axis of one value a place", () => {
  const points = [
    [2, 3],
    [3, 1],
    [3.5, NaN],
    [4, -1],
  ];
  equal(scale.line(points), "M10.0 5.0L60.0 25.0M110.0 45.0");
  equal(scale.of([1, 1]).y(1), 45);
});
