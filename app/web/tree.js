/** Tree: the nodes that grow from the current pair or a domain's, for each head side by side. */

import { ask, json, refused } from "./api.js";
import { heads } from "./headsets.js";
import { nodeMap } from "./nodemap.js";
import { orderBar } from "./order.js";
import { classColour, onTheme } from "./palette.js";
import { somePair } from "./pick.js";
import { change, state, watchIn } from "./store.js";
import { drawTree } from "./treeview.js";
import { escaped } from "./text.js";
import { theSetSoon } from "./theset.js";

const STOPS = Array.from({ length: 101 }, (_, i) => i / 100);
const scale = {
  orders: STOPS, meta: {},
  stop: (p) => Math.max(0, Math.min(100, Math.round(100 * p))),
};
const KINDS = {
  tree: "tree (DTG)", series: "series", parallel: "parallel",
  interpolation: "interpolation", none: "no generation",
};

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  const bar = orderBar($(".order-bar"), scale);
  let known = [{ name: "" }];
  let answers = [];
  let asking = null;
  let queued = 0;
  let onMap = null;

  const say = (sentence, problem = false) => {
    $(".wait").textContent = sentence;
    $(".wait").hidden = !sentence;
    $(".wait").classList.toggle("problem", problem);
  };

  async function grow() {
    queued = 0;
    asking?.abort();
    if (!state.tree && !state.vis && !state.tac) {
      $(".groves").innerHTML = "";
      say("Choose a pair first: click a point in Explore, or pick an example in Pair.");
      return;
    }
    asking = new AbortController();
    const { signal } = asking;
    const slow = setTimeout(() => say("Loading the head…"), 400);
    const question = state.tree ? { domain: state.tree } : { vis: state.vis, tac: state.tac };
    try {
      answers = await Promise.all(known.map(async (one, i) => {
        try {
          return { ...one, ...await ask("tree", { ...question, order: state.p, head: one.name }, signal) };
        } catch (error) {
          if (!i || error.name === "AbortError") throw error; // without the first head there is nothing to show
          refused(error, (sentence) => { one = { ...one, problem: sentence }; });
          return one;
        }
      }));
      say("");
      show();
      onMap?.(state.tree ? null : question, answers[0].order);
    } catch (error) {
      refused(error, (sentence) => {
        $(".groves").innerHTML = "";
        say(sentence, true);
      });
    } finally {
      clearTimeout(slow);
    }
  }

  /** While p is dragged, ask at most every 60 ms. */
  function soon() {
    if (state.p !== null) bar.show(scale.stop(state.p));
    if (!queued) queued = setTimeout(grow, 60);
  }

  function show() {
    const first = answers[0];
    if (state.p === null) change({ p: STOPS[scale.stop(first.order)] });
    bar.learned(first.learned);
    bar.show(scale.stop(state.p));
    const pair = [state.vis, state.tac].filter(Boolean).filter((ref, i, all) => all.indexOf(ref) === i).join(" and ").replaceAll("row:", "pair ").replaceAll("example:", "");
    $(".whose").textContent = state.tree
      ? `mean over its ${first.pairs} pairs at p = ${first.order.toFixed(2)}`
      : `${pair} at p = ${first.order.toFixed(2)}`;
    $(".groves").innerHTML = answers.map((one) => grove(one, answers.length > 1)).join("") + (answers.length > 1 ? "" : ALONE);
    $(".on-map").hidden = !onMap || Boolean(state.tree);
  }

  $(".of").onchange = (event) => change({ tree: event.target.value });
  watchIn("tree", ["vis", "tac", "tree", "p"], soon);
  onTheme(() => answers.length && show());
  const [set, found, examples] = await Promise.all([
    theSetSoon(), heads().catch(() => known), state.vis || state.tac ? [] : json("examples").catch(() => []),
  ]);
  known = found.filter((one) => !one.problem || !one.name);
  if (!set.frames) {
    somePair(examples, null);
    soon();
  }
  const { frames } = await (set.later ?? set);
  $(".of").innerHTML += frames.domains.map((name) => `<option value="${escaped(name)}">all of ${escaped(name)}</option>`).join("");
  if (state.tree && !frames.domains.includes(state.tree)) state.tree = "";
  $(".of").value = state.tree;
  onMap = nodeMap($(".on-map"), frames);
  somePair(examples, frames);
  soon();
}

const ALONE = `<p class="hint alone">Tree, series, parallel and interpolation are four ways to make as many nodes, and each needs a head trained with it: the nodes of an untrained one would mean nothing. Train one with <code>python -m omnivat train … --set generation=series</code> and open the page with <code>--compare DIR</code>: it then stands here beside this one.</p>`;

/** One head's nodes and cosines. */
function grove(one, several) {
  const title = several ? `${KINDS[one.generation] ?? one.generation} <small>head ‘${escaped(one.name || one.folder)}’, trained on ${escaped(one.source)}</small>` : `${KINDS[one.generation] ?? "Nodes"}`;
  if (!one.nodes) return `<div class="panel"><header><h3>${title}</h3></header><p class="hint">${escaped(one.problem)}</p></div>`;
  const right = one.nodes[0].right === undefined ? "" : " The second figure is the share of pairs that the node alone answers rightly.";
  const keys = one.classes.map((name, k) => `<span class="key"><i style="background:${classColour(k)}"></i>${escaped(name)}</span>`).join("");
  return `<div class="grove${several ? " several" : ""}"><div class="panel"><header><h3>${title}</h3></header><div class="nodes">${drawTree(one)}</div>
    <p class="hint legend-line">${keys} A disc’s area follows the node’s norm. The bar shows what the shared classifier gives the node by itself, the name its nearest class direction.${right}${one.in_use ? "" : " This head predicts without its tree (Alg. 2 to the letter)."}</p></div>
    <div class="panel layers"><header><h3>Cosines ${one.arrangement === "tree" ? "in each layer" : "of the nodes"}</h3><p class="hint">${NOD[one.arrangement] ?? ""} The figure is the distance that is left${one.pairs > 1 ? ", mean over pairs" : ""}.</p></header><div class="matrices">${one.layers.map((layer, level) => matrix(layer, level, one.arrangement)).join("")}</div></div></div>`;
}

const NOD = {
  tree: "NOD pushes each layer’s matrix towards the identity: siblings at right angles.",
  series: "NOD pushes the matrix of all nodes towards the identity.",
  parallel: "NOD pushes the matrix of the root’s children towards the identity.",
  interpolation: "These nodes lie on the line from VIS to TAC: nothing is learned, and NOD has nothing to push.",
};

function matrix({ nodes, cosines, nod }, level, arrangement) {
  const title = arrangement === "tree" ? `Layer ${level + 1}` : nodes.length === 1 ? "Root" : "Nodes";
  if (cosines.length === 1) return `<figure><figcaption>${title} <small>the root alone: nothing to keep apart</small></figcaption></figure>`;
  const cells = cosines.flatMap((row, i) => row.map((v, j) => {
    const strength = Math.round(100 * Math.min(1, Math.abs(v)));
    const hue = v < 0 ? "#0072b2" : "#d55e00";
    if (i === j) return '<td class="self" title="a node with itself">1</td>';
    const text = cosines.length <= 8 ? v.toFixed(2).replace("-0.00", "0.00") : "";
    return `<td style="--c:${hue};--s:${strength}%" class="${strength > 55 ? "deep" : ""}" title="nodes ${nodes[i] + 1} and ${nodes[j] + 1}: cosine ${v.toFixed(4)}">${text}</td>`;
  }).reduce((row, cell) => row + cell, "<tr>") + "</tr>");
  return `<figure><figcaption>${title} <small>nodes ${nodes[0] + 1} to ${nodes.at(-1) + 1} · ‖A − I‖ = ${nod.toFixed(3)}</small></figcaption><table class="cosines" aria-label="Cosines of ${title}"><tbody>${cells.join("")}</tbody></table></figure>`;
}
