/** The tree of the chosen pair as a drawing: a star for each node, as on the map. */

import { best } from "./numbers.js";
import { starOf } from "./pair-marks.js";
import { html, percent } from "./text.js";

const [WIDE, ROW, TOP] = [270, 56, 16]; // units of the drawing
const BELOW = 20; // from a leaf to its words

/** Return the corners of a star as text. @param {Point} place @param {number} radius */
const corners = (place, radius) =>
  starOf(place, radius)
    .map((corner) => corner.map((v) => v.toFixed(1)))
    .join(" ");

/** Return the nodes of each level, and where a node stands in a drawing of some width. @param {number[]} parents */
export function levelsOf(parents) {
  /** @type {number[]} */
  const depth = [];
  /** @type {number[][]} */
  const rows = [];
  parents.forEach((parent, i) => {
    depth[i] = parent < 0 ? 0 : depth[parent] + 1;
    (rows[depth[i]] ??= []).push(i);
  });
  /** @param {number} i @param {number} wide */
  const across = (i, wide) => ((rows[depth[i]].indexOf(i) + 0.5) / rows[depth[i]].length) * wide;
  return { depth, rows, across };
}

/** Return the tree at a stop, with what each node alone predicts. @param {Journey} journey @param {number} at */
export function treeSvg({ classes, tree: { parents, probabilities, in_use: used } }, at) {
  const { depth, rows, across } = levelsOf(parents);
  const place = (/** @type {number} */ i) => ({ x: across(i, WIDE), y: TOP + depth[i] * ROW });
  const edges = parents.map((parent, i) => {
    if (parent < 0) return null;
    const [from, to] = [place(parent), place(i)];
    return html`<line class="edge" x1="${from.x}" y1="${from.y}" x2="${to.x}" y2="${to.y}"/>`;
  });
  const last = rows.length - 1;
  const nodes = parents.map((_, i) => {
    const { x, y } = place(i);
    const { label: name, share } = best(classes, probabilities[at][i]);
    const words = `Node ${i + 1} alone predicts ${name}, ${percent(share)}`;
    // words stand below leaves, beside the root, and outside of what is between
    const inside = depth[i] < last || rows[last].length < 3;
    const anchor = !inside ? "middle" : i && x < WIDE / 2 ? "end" : "start";
    const [left, top] = inside ? [anchor === "end" ? x - 14 : x + 16, y - 2] : [x, y + BELOW + 4];
    const text = html`<text x="${left}" y="${top}" text-anchor="${anchor}">${name}</text>
      <text class="share" x="${left}" y="${top + 16}" text-anchor="${anchor}">${percent(share)}</text>`;
    return html`<g data-node="${i}" tabindex="0" role="listitem" aria-label="${words}"><title>${words}</title>
      <polygon class="star ${i === 0 && "root"}" points="${corners([x, y], i ? 10 : 13)}"/>${text}</g>`;
  });
  return html`<svg class="tree-of-pair" viewBox="0 0 ${WIDE} ${TOP + last * ROW + BELOW + 26}" role="list"
    aria-label="The tree of this pair; ${used ? "its nodes" : "its nodes, which this head does not use,"} are stars on
    the map">${edges}${nodes}</svg>`;
}
