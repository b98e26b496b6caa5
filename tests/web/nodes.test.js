/** The nodes of a pair: what is said of them, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import "./browser.js";
import { constant, nodesHtml, worth } from "../../app/web/explore/nodes.js";
import { says } from "./browser.js";

const VOTES = [
  { class: "wood", share: 0.4 },
  { class: "wood", share: 0.99 },
  { class: "glass", share: 1 },
];
const NODE = { norm: 1, probabilities: [0.7, 0.3] };
const ONE = {
  classes: ["wood", "glass"],
  arrangement: "tree",
  order: 0.5,
  learned: 0.5,
  in_use: true,
  parents: [-1, 0, 0],
  nodes: [NODE, NODE, NODE],
  layers: [
    { nodes: [0], cosines: [[1]] },
    {
      nodes: [1, 2],
      cosines: [
        [1, 0.2],
        [0.2, 1],
      ],
    },
  ],
};

test("of nodes with one class for nearly every pair, the page says that and concludes nothing", () => {
  assert.deepEqual(constant(VOTES), [false, true, true]);
  const said = `${worth(VOTES, 1920)}`;
  assert.match(said, /2 of 3 nodes/);
  assert.match(said, /alone, predict <i>wood<\/i> or <i>glass<\/i> for at least 95/);
  assert.ok(!/shift|direction/.test(said)); // equal classes do not show equal shifts
  says(worth([VOTES[0]], 10), /different classes for different pairs/);
});

test("constant nodes are drawn dashed once the set has been looked at, and only then", () => {
  assert.ok(!`${nodesHtml(ONE, {})}`.includes("fixed"));
  assert.equal(`${nodesHtml(ONE, { votes: VOTES, pairs: 10 })}`.match(/disc fixed/g).length, 2);
});

test("the mean cosine of each layer stands beside the right angles that NOD pushes it to", () => {
  says(nodesHtml(ONE, {}), /NOD pushes it to 0.*nodes 2–3: 0\.20/);
});

test("no leaf of a tree lies on another, however long its class is", () => {
  const nodes = Array.from({ length: 7 }, () => ({ ...NODE, probabilities: [0.3, 0.7] }));
  const classes = ["wood", "a class with a very long name"];
  const html = `${nodesHtml({ ...ONE, classes, parents: [-1, 0, 0, 1, 1, 2, 2], nodes }, {})}`;
  const names = [...html.matchAll(/class="name" x="([\d.]+)" y="[\d.]+">([^<]*)</g)].map(([, x, name]) => [+x, name]);
  assert.equal(names.length, 7);
  for (const [x, name] of names) assert.ok(x - 4 * name.length >= 0, name);
  const leaves = names.slice(3).map(([x]) => x);
  for (const [i, x] of leaves.slice(1).entries()) assert.ok(x - leaves[i] >= 8 * names[4][1].length, `${leaves}`);
});
