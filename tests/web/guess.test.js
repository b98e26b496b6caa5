/** A prediction for images unlike the training images is a guess, wherever it is shown. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { cards, classTable, liveHtml, rivalsHtml, spoken } from "../../app/web/pair/verdict.js";

const CLASSES = ["wood", "steel"];
const READINGS = { fused: [0.9, 0.1], vis: [0.8, 0.2], tac: [0.3, 0.7] };
const ANSWER = { classes: CLASSES, learned: 0.5, exact: { readings: READINGS } };
const STRANGE = { vis: { guess: true }, tac: { guess: false } };

test("the list of classes greys the columns of guesses and names them", () => {
  const html = String(classTable(ANSWER, { images: STRANGE }));
  const cells = (reading) => html.match(new RegExp(`<td data-reading="${reading}"[^>]*>`, "g"));
  for (const reading of ["fused", "vis"]) assert.ok(cells(reading).every((cell) => cell.includes("of-guess")));
  assert.ok(cells("tac").every((cell) => !cell.includes("of-guess")));
  assert.equal(html.match(/\(guess\)/g).length, 2);
  assert.match(html, /Grey: figures for a guess/);
  assert.doesNotMatch(String(classTable(ANSWER, { images: { vis: { guess: false } } })), /guess/);
});

test("no figure is shown or read out before the familiarity is known", () => {
  assert.doesNotMatch(String(cards(ANSWER, null, {})), /%/);
  assert.equal(spoken(ANSWER, { images: STRANGE }), "wood? This is a guess.");
  assert.match(spoken(ANSWER, { images: {} }), /^wood, 90/);
});

test("other heads and camera pictures show no figure of a guess", () => {
  const [, own, other] = String(rivalsHtml(ANSWER, [{ ...ANSWER, label: "other" }], { images: STRANGE })).split("<tr>");
  for (const row of [own, other].slice(1)) {
    assert.equal(row.match(/wood\?/g).length, 2);
    assert.match(row, /steel <b>70/);
  }
  const frame = { classes: CLASSES, readings: READINGS, images: STRANGE };
  const [both, photo, touch] = String(liveHtml(frame)).split("<article").slice(1);
  for (const html of [both, photo]) {
    assert.match(html, /This is a guess/);
    assert.ok(!html.includes("%"));
  }
  assert.match(touch, /steel <b>70/);
});
