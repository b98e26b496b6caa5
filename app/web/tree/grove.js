/** One head's nodes and their cosines. Text in, HTML out. */

import { classColour, rgb } from "../shared/palette.js";
import { each, escaped, percent } from "../shared/text.js";

export const KINDS = {
  tree: "Tree (DTG)",
  series: "Series",
  parallel: "Parallel",
  interpolation: "Interpolation",
  none: "No generation",
};
const NOD = {
  tree: "NOD pushes the matrix of cosines of each layer towards the identity: siblings at right angles.",
  series: "NOD pushes the matrix of cosines of all nodes towards the identity.",
  parallel: "NOD pushes the matrix of cosines of the root’s children towards the identity.",
  interpolation: "These nodes lie on the line from photo to touch. Nothing is learned and NOD does not apply.",
};

/** one: the server's reply for a head, with `votes` once loaded; several: true if there are more heads. */
export function grove(one, several) {
  const kind = KINDS[one.generation] ?? (several ? one.generation : "Nodes");
  const title = several
    ? `${kind} <small>head ‘${escaped(one.name || one.folder)}’, trained on ${escaped(one.source)}</small>`
    : kind;
  if (!one.nodes)
    return `<div class="panel"><header><h3>${title}</h3></header><p class="hint">${escaped(one.problem)}</p></div>`;
  return `<div class="grove${several ? " several" : ""}"><div class="panel"><header><h3>${title}</h3></header>
    <p class="worth">${worth(one.votes, one.of_pairs)}</p><div class="nodes">${drawTree({ ...one, constant: constant(one.votes) })}</div>${legend(one)}${layers(one)}</div></div>`;
}

function legend(one) {
  const keys = one.classes.map(
    (name, k) => `<span class="key"><i style="background:${classColour(k)}"></i>${escaped(name)}</span>`,
  );
  const right =
    one.nodes[0].right === undefined
      ? ""
      : " “Right” is the share of the domain’s pairs that the node alone predicts correctly.";
  const unused = one.in_use ? "" : " This head predicts without its tree (Alg. 2 as printed).";
  return `<p class="hint legend-line">${keys.join("")} Area: norm. Bar: its own prediction.${right}${unused}</p>`;
}

function layers(one) {
  const where = one.arrangement === "tree" ? "in each layer" : "of the nodes";
  const mean = one.pairs > 1 ? " Means over pairs." : "";
  const tables = one.layers.map((layer, level) => matrix(layer, level, one.arrangement));
  return `<details class="layers"><summary>Cosines ${where}</summary><p class="hint">${NOD[one.arrangement] ?? ""} 0 = perfectly orthogonal.${mean}</p><div class="matrices">${tables.join("")}</div></details>`;
}

function matrix({ nodes, cosines, nod }, level, arrangement) {
  const title = arrangement === "tree" ? `Layer ${level + 1}` : nodes.length === 1 ? "Root" : "Nodes";
  if (cosines.length === 1) return `<figure><figcaption>${title} <small>the root alone</small></figcaption></figure>`;
  const rows = cosines.map((row, i) => `<tr>${each(row, (v, j) => cell(v, nodes[i], nodes[j], cosines.length))}</tr>`);
  return `<figure><figcaption>${title} <small>nodes ${nodes[0] + 1} to ${nodes.at(-1) + 1} · distance to orthogonal ${nod.toFixed(3)}</small></figcaption><table class="cosines" aria-label="Cosines of ${title}"><tbody>${rows.join("")}</tbody></table></figure>`;
}

function cell(v, row, column, size) {
  if (row === column) return '<td class="self" title="a node with itself">1</td>';
  const strength = Math.round(100 * Math.min(1, Math.abs(v)));
  const text = size <= 8 ? v.toFixed(2).replace("-0.00", "0.00") : "";
  return `<td style="--c:${v < 0 ? "#0072b2" : "#d55e00"};--s:${strength}%" class="${strength > 55 ? "deep" : ""}" title="nodes ${row + 1} and ${column + 1}: cosine ${v.toFixed(4)}">${text}</td>`;
}

export const ALIKE = 0.95; // from this share of pairs on, a node counts as constant

/** votes: [{class, share}] of the nodes; returns the constant ones. */
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

const ROW = 132;
const RADIUS = 27; // of the node with the largest norm
const COLUMN = 122; // between the nodes of a series
const LABEL = 32; // height of the text under a disc
const LEAST = 0.84; // smallest scale of the drawing: its smallest letters have 12 units and need 10 pixels
/** Units of the whole drawing and of one column, on phones and elsewhere. */
const COLUMNS = { narrow: { least: 400, one: 100 }, wide: { least: 620, one: 140 }, bare: { least: 400, one: 64 } };
const isNarrow = () => globalThis.matchMedia?.("(max-width: 480px)").matches ?? false;

/** The depth of each node, and its index among the nodes of that depth. */
function laidOut(parents) {
  const depth = [];
  const rows = [];
  parents.forEach((parent, i) => {
    depth[i] = parent < 0 ? 0 : depth[parent] + 1;
    (rows[depth[i]] ??= []).push(i);
  });
  return { depth, rows };
}

/** Nodes in one line, for series and interpolation. */
function drawLine({ classes, nodes, parents, constant }) {
  const width = Math.max(COLUMNS[isNarrow() ? "narrow" : "wide"].least, nodes.length * COLUMN);
  const largest = Math.max(...nodes.map((node) => node.norm)) || 1;
  const radius = (i) => RADIUS * Math.sqrt(nodes[i].norm / largest);
  /** @type {(i: number) => [number, number]} */
  const place = (i) => [((i + 0.5) / nodes.length) * width, 36];
  const edges = parents.map((parent, i) =>
    parent < 0 ? "" : `<path class="edge" d="M${place(parent)[0] + radius(parent)} 36H${place(i)[0] - radius(i)}"/>`,
  );
  const discs = nodes.map((node, i) => disc(node, i, place(i), radius(i), classes, nodes.length <= 8, constant[i]));
  return `<svg class="tree-view" viewBox="0 0 ${width} 128" ${sized(width, 128)} role="list" aria-label="${nodes.length} nodes in a line">${edges.join("")}${discs.join("")}</svg>`;
}

export function drawTree({ classes, nodes, parents, constant = [] }) {
  if (nodes.length > 2 && parents.every((parent, i) => parent === i - 1 || parent < 0))
    return drawLine({ classes, nodes, parents, constant });
  const { depth, rows } = laidOut(parents);
  const widest = Math.max(...rows.map((row) => row.length));
  const fits = widest <= 8;
  const column = COLUMNS[fits ? (isNarrow() ? "narrow" : "wide") : "bare"];
  const width = Math.max(column.least, widest * column.one);
  const height = 44 + (rows.length - 1) * ROW + 84;
  const largest = Math.max(...nodes.map((node) => node.norm)) || 1;
  const radius = (i) => RADIUS * Math.sqrt(nodes[i].norm / largest);
  /** @type {(i: number) => [number, number]} */
  const place = (i) => {
    const row = rows[depth[i]];
    return [((row.indexOf(i) + 0.5) / row.length) * width, 36 + depth[i] * ROW];
  };
  const edges = parents.map((parent, i) => {
    if (parent < 0) return "";
    const [x0, above] = place(parent);
    const y0 = above + radius(parent) + (fits ? LABEL + (nodes[0].right === undefined ? 0 : 14) : 0);
    const [x1, y1] = place(i);
    const middle = (y0 + y1) / 2;
    return `<path class="edge" d="M${x0} ${y0}C${x0} ${middle} ${x1} ${middle} ${x1} ${y1}"/>`;
  });
  const discs = nodes.map((node, i) => disc(node, i, place(i), radius(i), classes, fits, constant[i]));
  return `<svg class="tree-view" viewBox="0 0 ${width} ${height}" ${sized(width, height)} role="list" aria-label="Tree of ${nodes.length} nodes">${edges.join("")}${discs.join("")}</svg>`;
}

/** As wide and high as its place, but never so small that its letters cannot be read. */
const sized = (width, height) =>
  `style="min-width:${Math.ceil(LEAST * width)}px;max-height:max(${height}px, calc(100vh - 330px))"`;

const isDeep = (hex) => rgb(hex).reduce((sum, v, c) => sum + v * [0.3, 0.59, 0.11][c], 0) < 110;

function disc({ norm, probabilities, right }, i, [x, y], r, classes, fits, fixed) {
  const best = probabilities.indexOf(Math.max(...probabilities));
  const parts = classes.map((name, k) => `${name} ${percent(probabilities[k], 1)}`).join(", ");
  const title = `<title>Node ${i + 1}${fixed ? ", one class for nearly every pair" : ""}: norm ${norm.toFixed(3)}; ${escaped(parts)}</title>`;
  const label = fits
    ? `<text class="name" x="${x}" y="${y + r + 17}">${escaped(classes[best])} ${percent(probabilities[best])}</text>
    ${bar(probabilities, x - 46, y + r + 23)}${typeof right !== "number" ? "" : `<text x="${x}" y="${y + r + 43}">${percent(right)} right</text>`}`
    : "";
  return `<g tabindex="0" role="listitem" aria-label="Node ${i + 1}, norm ${norm.toFixed(2)}, ${escaped(parts)}">${title}
    <circle class="disc${fixed ? " fixed" : ""}" cx="${x}" cy="${y}" r="${r}" style="fill:${classColour(best)}"/><text class="index${isDeep(classColour(best)) ? " pale" : ""}" x="${x}" y="${y + 5}">${i + 1}</text>${label}</g>`;
}

function bar(probabilities, left, top) {
  let x = left;
  return each(probabilities, (p, k) => {
    const rect = `<rect x="${x.toFixed(1)}" y="${top}" width="${(92 * p).toFixed(1)}" height="6" style="fill:${classColour(k)}"/>`;
    x += 92 * p;
    return rect;
  });
}
