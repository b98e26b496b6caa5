/** Tree: the nodes of the current pair or of a domain, for each head side by side. */

import { ask, attempt, isCancelled, json, refused } from "../shared/api.js";
import { nearest } from "../shared/frames.js";
import { needsHead } from "../shared/headless.js";
import { heads } from "../shared/headsets.js";
import { nodeMap } from "../shared/nodemap.js";
import { orderBar } from "../shared/order.js";
import { onTheme } from "../shared/palette.js";
import { somePair } from "../shared/pick.js";
import { change, state, watchIn } from "../shared/store.js";
import { each, options } from "../shared/text.js";
import { theSetSoon } from "../shared/theset.js";
import { tell, View } from "../shared/view.js";
import { grove } from "./grove.js";

const STOPS = Array.from({ length: 101 }, (_, i) => i / 100);
const SAME = 1e-6;
/** The visitor's p; null for the one that a chapter of Explore opened with. */
const chosen = () => (state.p === state.opened ? null : state.p);

/** The stops of the bar: hundredths, and exactly the learned p once it is known. */
function scaleOf(learned) {
  const orders = learned >= 0 && learned <= 1 ? [...STOPS, learned].sort((a, b) => a - b) : STOPS;
  return { orders, learned, meta: { head: {} }, stop: (p) => nearest(orders, p) };
}

export async function start(root) {
  if (await needsHead(root)) return;
  const tab = new TreeTab(root);
  let problem = "";
  const told = (error) => {
    refused(error, (sentence) => (problem = sentence));
    return tab.known;
  };
  const [set, found, examples] = await Promise.all([
    theSetSoon(),
    heads().catch(told),
    state.vis || state.tac ? [] : json("examples").catch(() => []),
  ]);
  if (problem) return tab.say(problem, true);
  tab.known = found.filter((one) => !one.problem || !one.name);
  if (!set.frames) {
    somePair(examples, null);
    tab.soon();
  }
  const { frames } = await (set.later ?? set);
  tab.adopt(frames);
  somePair(examples, frames);
  tab.soon();
}

class TreeTab extends View {
  constructor(root) {
    super(root);
    this.scale = scaleOf(NaN);
    this.bar = orderBar(this.$(".order-bar"), this.scale);
    this.known = [{ name: "" }];
    this.trees = [];
    this.votes = new Map(); // head -> most frequent class of each node
    this.asking = null;
    this.queued = 0;
    this.onMap = null;
    this.$(".of").onchange = (event) => change({ tree: event.target.value });
    watchIn("tree", ["vis", "tac", "tree", "p"], () => this.soon());
    onTheme(() => this.trees.length && this.show());
  }

  say(sentence, problem = false) {
    tell(this.$(".wait"), sentence, problem);
  }

  /** The set's map has arrived: offer its domains, and place nodes on it. */
  adopt(frames) {
    this.$(".of").innerHTML += options(frames.domains.map((name) => [name, `all of ${name}`]));
    if (state.tree && !frames.domains.includes(state.tree)) state.tree = "";
    this.$(".of").value = state.tree;
    this.onMap = nodeMap(this.$(".on-map"), frames);
  }

  /** While p is dragged, send at most one request every 60 ms. */
  soon() {
    if (chosen() !== null) this.bar.show(this.scale.stop(state.p));
    if (!this.queued) this.queued = setTimeout(() => this.grow(), 60);
  }

  /** The p to request: null is the learned one. */
  get order() {
    const learned = this.trees[0]?.learned;
    return chosen() !== null && Math.abs(state.p - learned) < SAME ? null : chosen();
  }

  async grow() {
    this.queued = 0;
    this.asking?.abort();
    if (!state.tree && !state.vis && !state.tac) {
      this.$(".groves").innerHTML = "";
      this.say("Choose a pair first: click a point in Explore, or pick an example in Try a pair.");
      return;
    }
    this.asking = new AbortController();
    const { signal } = this.asking;
    const slow = setTimeout(() => this.say("Loading the head…"), 400);
    const question = state.tree ? { domain: state.tree } : { vis: state.vis, tac: state.tac };
    try {
      this.trees = await Promise.all(this.known.map((one, i) => this.grown(one, i, question, signal)));
      this.say("");
      this.show();
      this.onMap?.(state.tree ? null : question, this.trees[0].order);
      this.vote();
    } catch (error) {
      refused(error, (sentence) => {
        this.$(".groves").innerHTML = "";
        this.say(sentence, true);
      });
    } finally {
      clearTimeout(slow);
    }
  }

  /** One head's nodes, or the reason it has none; without the first head nothing is shown. */
  async grown(one, place, question, signal) {
    try {
      const found = await ask("tree", { ...question, order: this.order, head: one.name }, signal);
      return { ...one, ...found };
    } catch (error) {
      if (!place || isCancelled(error)) throw error;
      let problem = "";
      refused(error, (sentence) => (problem = sentence));
      return { ...one, problem };
    }
  }

  /** Request once for each head the nodes that give one class to every pair; the tree does not wait for it. */
  async vote() {
    for (const { name, nodes } of this.trees) {
      if (!nodes || this.votes.has(name)) continue;
      this.votes.set(name, null);
      await attempt(
        async () => {
          // the head cannot read this set: show the tree without it
          this.votes.set(name, await ask("votes", { head: name }));
          this.show();
        },
        () => this.votes.set(name, {}),
      );
    }
    this.$(".groves").setAttribute("aria-busy", [...this.votes.values()].includes(null));
  }

  show() {
    const [first] = this.trees;
    if (chosen() === null) change({ p: first.order }); // not rounded: the learned p is another one than its nearest hundredth
    if (this.scale.learned !== first.learned) {
      this.scale = scaleOf(first.learned);
      this.bar.replace(this.scale);
    }
    this.bar.learned(first.learned);
    this.bar.show(this.scale.stop(state.p));
    this.$(".whose").textContent =
      `${whose(first)} at p = ${first.order.toFixed(3)}${first.order === first.learned ? " (learned)" : ", a what-if: weights are those of the learned p"}`;
    const voted = this.trees.map((one) => {
      const found = this.votes.get(one.name ?? "");
      return { ...one, votes: found?.votes, of_pairs: found?.pairs };
    });
    const several = voted.length > 1;
    const groves = this.$(".groves");
    const at = [...groves.querySelectorAll("[tabindex]")].indexOf(document.activeElement);
    groves.innerHTML = each(voted, (one) => grove(one, several));
    groves.querySelectorAll("[tabindex]")[at]?.focus(); // votes come late: the keys stay where they are
    this.$(".on-map").hidden = !this.onMap || Boolean(state.tree);
  }
}

/** The source of the tree, in words. */
function whose(first) {
  if (state.tree) return `Mean over its ${first.pairs} pairs`;
  const refs = [...new Set([state.vis, state.tac].filter(Boolean))];
  return refs.join(" and ").replaceAll("row:", "Pair ").replaceAll("example:", "");
}
