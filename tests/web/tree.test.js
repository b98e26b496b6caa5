/** Tree: what it says of nodes, without a browser. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { constant, grove, worth } from "../../app/web/tree/grove.js";

const VOTES = [
  { class: "wood", share: 0.4 },
  { class: "wood", share: 0.99 },
  { class: "glass", share: 1 },
];
const NODE = { norm: 1, probabilities: [0.7, 0.3] };
const ONE = {
  name: "",
  classes: ["wood", "glass"],
  arrangement: "tree",
  generation: "tree",
  in_use: true,
  source: "TAG-sim",
  pairs: 1,
  parents: [-1, 0, 0],
  nodes: [NODE, NODE, NODE],
  layers: [
    { nodes: [0], cosines: [[1]], nod: 0 },
    {
      nodes: [1, 2],
      cosines: [
        [1, 0.2],
        [0.2, 1],
      ],
      nod: 0.28,
    },
  ],
};

test("of nodes with one class for nearly every pair, the page says that and concludes nothing", () => {
  assert.deepEqual(constant(VOTES), [false, true, true]);
  const said = worth(VOTES, 1920);
  assert.match(said, /2 of 3 nodes/);
  assert.match(said, /alone predict <i>wood<\/i> or <i>glass<\/i> for at least 95/);
  assert.ok(!/shift|direction/.test(said)); // equal classes do not show equal shifts
  assert.match(worth([VOTES[0]], 10), /different classes for different pairs/);
});

test("constant nodes are drawn dashed once the set has been looked at, and only then", () => {
  assert.ok(!grove(ONE, false).includes("fixed"));
  assert.equal(grove({ ...ONE, votes: VOTES, of_pairs: 10 }, false).match(/disc fixed/g).length, 2);
});

test("a head that has no nodes says why", () => {
  assert.match(
    grove({ name: "x", problem: "This head generates no nodes.", generation: "none" }, true),
    /generates no nodes/,
  );
});

test("NOD is said to push the matrix of cosines, not the matrix", () => {
  assert.match(grove(ONE, false), /NOD pushes the matrix of cosines of each layer towards the identity/);
});
