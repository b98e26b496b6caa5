/** The nodes that the head's tree grows from the pinned pair: what each alone predicts, at the p on the screen. */

import { ask, attempt } from "../shared/api.js";
import { keys } from "../shared/filters.js";
import { best, mean } from "../shared/numbers.js";
import { levelsOf } from "../shared/pair-tree.js";
import { classColour, rgb } from "../shared/palette.js";
import { awaited } from "../shared/ready.js";
import { panelIsOpen } from "./panels.js";
import { $, fill, grouped, html, percent, scene, send, state } from "./root.js";

const PAUSE = 60; // ms: at most one request in it while p is dragged
const LETTERS = 9; // of a class below its node
const ALIKE = 0.95; // from this share of pairs on, a node counts as constant
const [ROW, COLUMN, RADIUS, LEAST] = [126, 74, 24, 296]; // units of the drawing
/** @typedef {Replies["votes"]["votes"]} Votes */

let asking = new AbortController(); // a handle: of the request that is on its way

/** Draw the tree again once the pin or p has changed. */
export function follow() {
  if (state.chapter !== "analyse" || !panelIsOpen("nodes")) return;
  asking.abort();
  if (state.pin === null) return fill($(".nodes"), html`<p class="hint">Click a point on the map to pin a pair.</p>`);
  const { signal } = (asking = new AbortController());
  awaited(new Promise((done) => setTimeout(done, PAUSE)).then(() => (signal.aborted ? undefined : grow(signal))));
}

/** Fetch the tree of the pinned pair, draw it, then add each node's most frequent class over the set.
 * @param {AbortSignal} signal */
const grow = (signal) =>
  attempt(
    async () => {
      const ref = `row:${state.pin}`;
      const order = scene.frames.orders[scene.stop];
      const tree = await ask("tree", { vis: ref, tac: ref, order }, signal);
      show(tree);
      if (scene.votes) return;
      send("arrived", { votes: {} });
      send("arrived", { votes: await ask("votes", { head: "" }) });
      show(tree);
    },
    (/** @type {string} */ sentence) => fill($(".nodes"), html`${sentence}`),
  );

/** @param {Tree} tree */
function show(tree) {
  fill($(".nodes"), nodesHtml(tree, scene.votes ?? {}));
}

/** tree: the server's reply; votes: of each node over the set, once known.
 * @param {Tree} tree @param {Partial<Replies["votes"]>} set */
export function nodesHtml(tree, { votes, pairs }) {
  return html`<p class="hint">The tree (DTG) that the loaded head grows at p = ${tree.order.toFixed(3)}; its learned p
    is ${tree.learned.toFixed(3)}.${!tree.in_use && " This head predicts without its tree."}</p>
    ${drawTree(tree, constant(votes))}
    <p class="hint">${keys(tree.classes.map((name, k) => [name, classColour(k)]))} Circle area: size (norm) of the
      node. Bar: class probabilities from this node alone.</p><p class="worth">${worth(votes, pairs)}</p>
      ${angles(tree)}`;
}

/** Return which nodes are constant. @param {Votes | undefined} votes */
export const constant = (votes) => (votes ?? []).map(({ share }) => share >= ALIKE);

/** Return a sentence about the constant nodes of a tree. @param {Votes} [votes] */
export function worth(votes, pairs = 0) {
  if (!votes) return html``;
  const fixed = votes.filter(({ share }) => share >= ALIKE);
  if (!fixed.length)
    return html`Each of the ${votes.length} nodes, used alone, predicts different classes for different pairs.`;
  const classes = [...new Set(fixed.map((node) => node.class))].map(
    (name, i) => html`${i > 0 && " or "}<i>${name}</i>`,
  );
  return html`<b>${fixed.length} of ${votes.length} nodes</b> (dashed), used alone, predict ${classes} for at
    least ${percent(ALIKE)} of the ${grouped(pairs)} pairs of the set.`;
}

/** Return how near the nodes of each layer are to right angles, which NOD pushes them to. @param {Tree} tree */
function angles({ layers, arrangement }) {
  const shown = layers.filter(({ cosines }) => cosines.length > 1);
  if (arrangement === "interpolation" || !shown.length) return null;
  const words = shown.map(({ nodes, cosines }) => {
    const off = cosines.flatMap((row, i) => row.filter((_, j) => i !== j).map(Math.abs));
    return html`<li>nodes ${nodes[0] + 1}–${nodes[nodes.length - 1] + 1}: ${mean(off).toFixed(2)}</li>`;
  });
  return html`<p class="hint">Mean |cosine| between nodes of a level. The loss NOD pushes it to 0 (right angles):</p>
    <ul class="angles">${words}</ul>`;
}

/** Return the tree as a drawing; `fixed` marks the constant nodes. @param {Tree} tree @param {boolean[]} fixed */
function drawTree({ classes, nodes, parents }, fixed) {
  const { depth, rows, across } = levelsOf(parents);
  const width = Math.max(LEAST, ...rows.map((row) => row.length * COLUMN));
  const largest = Math.max(...nodes.map(({ norm }) => norm)) || 1;
  const placed = nodes.map((node, i) => {
    const r = RADIUS * Math.sqrt(node.norm / largest);
    return { ...node, x: across(i, width), y: 30 + depth[i] * ROW, r };
  });
  const edges = placed.map(({ x, y }, i) => {
    const above = placed[parents[i]];
    if (!above) return null;
    const top = above.y + above.r + 44;
    const middle = (top + y) / 2;
    return html`<path class="edge" d="M${above.x} ${top}C${above.x} ${middle} ${x} ${middle} ${x} ${y}"/>`;
  });
  const discs = placed.map((node, i) => disc(node, i + 1, classes, fixed[i]));
  return html`<svg class="chart tree-view" viewBox="0 0 ${width} ${rows.length * ROW}" role="list"
    aria-label="Tree of ${nodes.length} nodes">${edges}${discs}</svg>`;
}

const short = (/** @type {string} */ name) => (name.length > LETTERS ? `${name.slice(0, LETTERS - 1)}…` : name);
const isDeep = (/** @type {string} */ hex) => rgb(hex).reduce((sum, v, c) => sum + v * [0.3, 0.59, 0.11][c], 0) < 110;

/** Return a node as a disc with its class and a bar of its probabilities.
 * @param {{norm: number, probabilities: number[], x: number, y: number, r: number}} node @param {number} number
 * @param {string[]} classes @param {boolean} fixed */
function disc({ norm, probabilities, x, y, r }, number, classes, fixed) {
  const { at, label, share } = best(classes, probabilities);
  const colour = classColour(at);
  const parts = classes.map((name, k) => `${name} ${percent(probabilities[k], 1)}`).join(", ");
  const side = COLUMN - 14;
  let left = x - side / 2;
  const bar = probabilities.map((p, k) => {
    const rect = html`<rect x="${left.toFixed(1)}" y="${y + r + 35}" width="${(side * p).toFixed(1)}" height="6"
      style="fill:${classColour(k)}"/>`;
    left += side * p;
    return rect;
  });
  return html`<g tabindex="0" role="listitem" aria-label="Node ${number}, norm ${norm.toFixed(2)}, ${parts}">
    <title>Node ${number}: norm ${norm.toFixed(3)}; ${parts}</title>
    <circle class="disc${fixed && " fixed"}" cx="${x}" cy="${y}" r="${r}" style="fill:${colour}"/>
      <text class="index${isDeep(colour) && " pale"}" x="${x}" y="${y + 5}">${number}</text>
    <text class="name" x="${x}" y="${y + r + 15}">${short(label)}
      <tspan x="${x}" dy="15">${percent(share)}</tspan></text>${bar}</g>`;
}
