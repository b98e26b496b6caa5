/** Tree: the nodes that grow from the current pair, and the cosines that NOD keeps low. */

import { ask, json, refused } from "./api.js";
import { orderBar } from "./order.js";
import { classColour, onTheme } from "./palette.js";
import { somePair } from "./pick.js";
import { change, state, watch } from "./store.js";
import { drawTree } from "./treeview.js";
import { escaped } from "./text.js";
import { theSet } from "./theset.js";

const STOPS = Array.from({ length: 101 }, (_, i) => i / 100);
const scale = {
  orders: STOPS, meta: {},
  stop: (p) => Math.max(0, Math.min(100, Math.round(100 * p))),
};

export async function start(root) {
  const $ = (selector) => root.querySelector(selector);
  const bar = orderBar($(".order-bar"), scale);
  let answer = null;
  let asking = null;
  let queued = 0;

  const say = (sentence, problem = false) => {
    $(".wait").textContent = sentence;
    $(".wait").hidden = !sentence;
    $(".wait").classList.toggle("problem", problem);
  };

  async function grow() {
    queued = 0;
    if (!state.vis && !state.tac) {
      $(".grove").hidden = true;
      say("Choose a pair first: click a point in Explore, or pick an example in Pair.");
      return;
    }
    asking?.abort();
    asking = new AbortController();
    const slow = setTimeout(() => say("Loading the head…"), 400);
    try {
      answer = await ask("tree", { vis: state.vis, tac: state.tac, order: state.p }, asking.signal);
      say("");
      show();
    } catch (error) {
      refused(error, (sentence) => {
        $(".grove").hidden = true;
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
    if (state.p === null) change({ p: STOPS[scale.stop(answer.order)] });
    $(".grove").hidden = false;
    bar.learned(answer.learned);
    bar.show(scale.stop(state.p));
    $(".whose").textContent = `of ${[state.vis, state.tac].filter(Boolean).filter((ref, i, all) => all.indexOf(ref) === i).join(" and ").replaceAll("row:", "pair ").replaceAll("example:", "")} at p = ${answer.order.toFixed(2)}`;
    $(".nodes").innerHTML = drawTree(answer);
    $(".legend-line").innerHTML = `${answer.classes.map((name, k) => `<span class="key"><i style="background:${classColour(k)}"></i>${escaped(name)}</span>`).join("")} A disc’s area follows the node’s norm. The bar shows what the shared classifier gives the node by itself, the name its nearest class direction.${answer.in_use ? "" : " This head predicts without its tree (Alg. 2 to the letter)."}`;
    $(".matrices").innerHTML = answer.layers.map(matrix).join("");
  }
  watch(["vis", "tac"], soon);
  watch(["p"], soon);
  onTheme(() => answer && show());
  if (!state.vis && !state.tac) {
    const set = await theSet().catch(() => null);
    somePair(await json("examples").catch(() => []), set?.frames);
  }
  soon();
}

function matrix({ nodes, cosines, nod }, level) {
  if (cosines.length === 1) return `<figure><figcaption>Layer 1 <small>the root alone: nothing to keep apart</small></figcaption></figure>`;
  const cells = cosines.flatMap((row, i) => row.map((v, j) => {
    const strength = Math.round(100 * Math.min(1, Math.abs(v)));
    const hue = v < 0 ? "#0072b2" : "#d55e00";
    if (i === j) return '<td class="self" title="a node with itself">1</td>';
    const text = cosines.length <= 8 ? (Object.is(v.toFixed(2), "-0.00") ? "0.00" : v.toFixed(2)) : "";
    return `<td style="--c:${hue};--s:${strength}%" class="${strength > 55 ? "deep" : ""}" title="nodes ${nodes[i] + 1} and ${nodes[j] + 1}: cosine ${v.toFixed(4)}">${text}</td>`;
  }).reduce((row, cell) => row + cell, "<tr>") + "</tr>");
  return `<figure><figcaption>Layer ${level + 1} <small>nodes ${nodes[0] + 1} to ${nodes.at(-1) + 1} · NOD ‖A − I‖ = ${nod.toFixed(3)}</small></figcaption><table class="cosines" aria-label="Cosines of layer ${level + 1}"><tbody>${cells.join("")}</tbody></table></figure>`;
}
