/** One head's nodes and their cosines. Text in, HTML out. */

import { classColour } from "../shared/palette.js";
import { escaped } from "../shared/text.js";
import { drawTree } from "./treeview.js";
import { constant, worth } from "./votes.js";

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
  const rows = cosines.map(
    (row, i) => `<tr>${row.map((v, j) => cell(v, nodes[i], nodes[j], cosines.length)).join("")}</tr>`,
  );
  return `<figure><figcaption>${title} <small>nodes ${nodes[0] + 1} to ${nodes.at(-1) + 1} · distance to orthogonal ${nod.toFixed(3)}</small></figcaption><table class="cosines" aria-label="Cosines of ${title}"><tbody>${rows.join("")}</tbody></table></figure>`;
}

function cell(v, row, column, size) {
  if (row === column) return '<td class="self" title="a node with itself">1</td>';
  const strength = Math.round(100 * Math.min(1, Math.abs(v)));
  const text = size <= 8 ? v.toFixed(2).replace("-0.00", "0.00") : "";
  return `<td style="--c:${v < 0 ? "#0072b2" : "#d55e00"};--s:${strength}%" class="${strength > 55 ? "deep" : ""}" title="nodes ${row + 1} and ${column + 1}: cosine ${v.toFixed(4)}">${text}</td>`;
}
