/** The nodes that the head's tree grows from the pinned pair: what each alone predicts, at the p on the screen. */

import { ask, refused } from "../shared/api.js";
import { classColour, rgb } from "../shared/palette.js";
import { awaited } from "../shared/ready.js";
import { state } from "../shared/store.js";
import { define } from "../shared/terms.js";
import { each, escaped, percent } from "../shared/text.js";
import { View } from "../shared/view.js";

const PAUSE = 60; // ms: at most one request in it while p is dragged
const ALIKE = 0.95; // from this share of pairs on, a node counts as constant
const [ROW, COLUMN, RADIUS, LEAST] = [112, 92, 24, 300]; // units of the drawing
const NONE = "Pin a pair: click a point of the map.";

export class Nodes extends View {
  /** `shows()` is true while the panel is open. */
  constructor(box, scene, shows) {
    super(box);
    this.scene = scene;
    this.shows = shows;
    /** @type {any} */
    this.tree = null;
    /** @type {any} */
    this.votes = null; // {votes: [{class, share}], pairs} over the whole set
    this.asking = new AbortController();
  }

  /** The pin or p has changed. */
  follow() {
    if (!this.shows()) return;
    this.asking.abort();
    if (state.pin === null) {
      this.tree = null;
      this.box.innerHTML = `<p class="hint">${NONE}</p>`;
      return;
    }
    const mine = (this.asking = new AbortController());
    awaited(
      new Promise((done) => setTimeout(done, PAUSE)).then(() =>
        mine.signal.aborted ? undefined : this.grow(mine.signal),
      ),
    );
  }

  async grow(signal) {
    const ref = `row:${state.pin}`;
    try {
      this.tree = await ask("tree", { vis: ref, tac: ref, order: this.scene.p }, signal);
      this.show();
      if (this.votes) return;
      this.votes = {};
      this.votes = await ask("votes", { head: "" });
      this.show();
    } catch (error) {
      refused(error, this.box);
    }
  }

  show() {
    if (!this.tree) return;
    this.box.innerHTML = nodesHtml(this.tree, this.votes ?? {});
    define(this.box);
  }
}

/** tree: the server's reply; votes: of each node over the set, once known. */
export function nodesHtml(tree, { votes, pairs }) {
  const keys = each(
    tree.classes,
    (name, k) => `<span class="key"><i style="background:${classColour(k)}"></i>${escaped(name)}</span>`,
  );
  const moved = Math.abs(tree.order - tree.learned) > 1e-3 ? ", moved from its learned p" : ", its learned p";
  const unused = tree.in_use ? "" : " This head predicts without its tree.";
  return `<p class="hint">The loaded head at p = ${tree.order.toFixed(3)}${moved}.${unused}</p>${drawTree({ ...tree, constant: constant(votes) })}
    <p class="hint">${keys} Area: norm. Bar: what the node alone predicts.</p><p class="worth">${worth(votes, pairs)}</p>${angles(tree)}`;
}

/** votes: [{class, share}] of the nodes; which of them are constant. */
export const constant = (votes) => (votes ?? []).map(({ share }) => share >= ALIKE);

/** A sentence about the constant nodes of a tree. */
export function worth(votes, pairs) {
  if (!votes) return "";
  const fixed = constant(votes).filter(Boolean).length;
  const names = [...new Set(votes.filter(({ share }) => share >= ALIKE).map((one) => one.class))];
  if (!fixed) return `Each of the ${votes.length} nodes alone predicts different classes for different pairs.`;
  const classes = names.map((name) => `<i>${escaped(name)}</i>`).join(" or ");
  return `<b>${fixed} of ${votes.length} nodes</b> (dashed) alone predict ${classes} for at least ${percent(ALIKE)} of the set’s ${pairs.toLocaleString("en-US")} pairs.`;
}

/** How near the nodes of each layer are to right angles, which NOD pushes them to. */
function angles({ layers, arrangement }) {
  const shown = layers.filter(({ cosines }) => cosines.length > 1);
  const mean = ({ cosines }) => {
    const off = cosines.flatMap((row, i) => row.filter((_, j) => i !== j).map(Math.abs));
    return off.reduce((sum, v) => sum + v, 0) / off.length;
  };
  const words = each(
    shown,
    (layer) => `<li>nodes ${layer.nodes[0] + 1}–${layer.nodes.at(-1) + 1}: ${mean(layer).toFixed(2)}</li>`,
  );
  return arrangement === "interpolation" || !words
    ? ""
    : `<p class="hint">Mean |cosine|; NOD pushes it to 0 (right angles):</p><ul class="angles">${words}</ul>`;
}

function drawTree({ classes, nodes, parents, constant }) {
  const depth = [];
  const rows = [];
  parents.forEach((parent, i) => {
    depth[i] = parent < 0 ? 0 : depth[parent] + 1;
    (rows[depth[i]] ??= []).push(i);
  });
  const width = Math.max(LEAST, Math.max(...rows.map((row) => row.length)) * COLUMN);
  const height = rows.length * ROW;
  const largest = Math.max(...nodes.map(({ norm }) => norm)) || 1;
  const radius = (i) => RADIUS * Math.sqrt(nodes[i].norm / largest);
  /** @type {(i: number) => [number, number]} */
  const place = (i) => {
    const row = rows[depth[i]];
    return [((row.indexOf(i) + 0.5) / row.length) * width, 30 + depth[i] * ROW];
  };
  const edges = parents.map((parent, i) => {
    if (parent < 0) return "";
    const [[x0, above], [x1, y1]] = [place(parent), place(i)];
    const y0 = above + radius(parent) + 30;
    const middle = (y0 + y1) / 2;
    return `<path class="edge" d="M${x0} ${y0}C${x0} ${middle} ${x1} ${middle} ${x1} ${y1}"/>`;
  });
  const discs = nodes.map((node, i) => disc(node, i, place(i), radius(i), classes, constant[i]));
  return `<svg class="tree-view" viewBox="0 0 ${width} ${height}" role="list" aria-label="Tree of ${nodes.length} nodes">${edges.join("")}${discs.join("")}</svg>`;
}

const isDeep = (hex) => rgb(hex).reduce((sum, v, c) => sum + v * [0.3, 0.59, 0.11][c], 0) < 110;

function disc({ norm, probabilities }, i, [x, y], r, classes, fixed) {
  const best = probabilities.indexOf(Math.max(...probabilities));
  const parts = escaped(classes.map((name, k) => `${name} ${percent(probabilities[k], 1)}`).join(", "));
  let left = x - 38;
  const bar = each(probabilities, (p, k) => {
    const rect = `<rect x="${left.toFixed(1)}" y="${y + r + 20}" width="${(76 * p).toFixed(1)}" height="6" style="fill:${classColour(k)}"/>`;
    left += 76 * p;
    return rect;
  });
  return `<g tabindex="0" role="listitem" aria-label="Node ${i + 1}, norm ${norm.toFixed(2)}, ${parts}"><title>Node ${i + 1}: norm ${norm.toFixed(3)}; ${parts}</title>
    <circle class="disc${fixed ? " fixed" : ""}" cx="${x}" cy="${y}" r="${r}" style="fill:${classColour(best)}"/><text class="index${isDeep(classColour(best)) ? " pale" : ""}" x="${x}" y="${y + 5}">${i + 1}</text>
    <text class="name" x="${x}" y="${y + r + 15}">${escaped(classes[best])} ${percent(probabilities[best])}</text>${bar}</g>`;
}
