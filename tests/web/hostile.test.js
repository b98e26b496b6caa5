/** Names from files and from visitors never become tags. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { headOf, whence } from "../../app/web/explore/chapters.js";
import { neighboursHtml } from "../../app/web/explore/grid.js";
import { modeWords } from "../../app/web/explore/modes.js";
import { START } from "../../app/web/pair/state.js";
import { lineHtml } from "../../app/web/pair/steps.js";
import { familiarHtml } from "../../app/web/pair/verdict.js";
import { card } from "../../app/web/shared/card.js";
import { frames } from "./browser.js";

const NAME = `"'><img src=x onerror=alert(1)>`;
const set = {
  ...frames({ head: { kind: "retrained", source: NAME }, curves: { "accuracy/unseen": [1, 1, 1] } }),
  ...{ classes: [NAME, NAME], domains: [NAME, NAME], prediction: [0, 0], confidence: [9, 9] },
};
const sprite = { tile: 8, columns: 2, count: 4, url: "x.webp" };
const clean = (html) => assert.ok(html && !/<img|"'>/.test(html), html);

test("classes and domains of a set stay text in cards, neighbours, familiarity and words", () => {
  clean(`${neighboursHtml([{ point: 1, cosine: 0.5 }], { frames: set, sprite })}`);
  clean(card(set, sprite, 0, 0, true, 0, { name: [NAME], looks_like: [NAME], feels_like: [NAME] }));
  const image = { words: "familiar", quantile: 0.5, cosine: 0.5, nearest: [{ pair: 0, cosine: 0.5 }] };
  clean(String(familiarHtml({ images: { vis: image }, of: NAME }, { frames: set, sprite })));
  clean(`${headOf(set, 0)} ${whence(set, 0)}`);
  clean(`${modeWords(set)}`);
});

test("a visitor's label stays text in the line of the own pictures", () => {
  const pairs = [{ vis: "image:1", label: NAME }];
  clean(String(lineHtml({ ...START, pairs })));
});
