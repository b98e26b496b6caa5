import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";

const { searched } = await import("../../app/web/data/data.js");

test("the curve of a search names its lowest point and where the gradient started", () => {
  const html = searched({ start: 0.36, orders: [0, 1, 0.35], score: [1.6, 1.5, 0.2], spread: [0.1, 0.1, 0.1] });
  assert.match(html, /lowest, 0.20, at p = 0.35/);
  assert.match(html, /p = 0.360/);
  assert.equal(html.match(/class="line" d="M[^M]*L[^M]*L/g)?.length, 1);
});

test("a head without a search has no curve, and damaged values cannot become markup", () => {
  assert.equal(searched(undefined), "");
  assert.equal(searched({ orders: ["<b>", 1], score: [1, 1], spread: [0, 0] }), "");
});
