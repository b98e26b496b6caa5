/** The few things of a browser that scripts touch when they are imported; each test file has its own. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

const rungs = [
  { id: "none", words: "nothing: as they come", map: 0 },
  { id: "spread", words: "mean and spread", map: 2 },
  { id: "n20", words: "20 pairs", step: 2 },
  { id: "k3", words: "three labels", step: 3 },
];
const file = readFileSync(new URL("../../app/web/shared/tables.json", import.meta.url), "utf8");
const rows = JSON.stringify({ ...JSON.parse(file), rungs, domains: [{ id: "TAG", title: "GelSight (TAG)" }] });
globalThis.document ??= {
  querySelector: (what) => (what === "#omnivat-tables" ? { textContent: rows } : null),
  body: { classList: { contains: () => false }, dataset: {} },
  baseURI: "http://x/",
};
globalThis.location ??= { search: "", href: "http://x/" };
globalThis.OffscreenCanvas ??= class {
  getContext = () => ({});
};
globalThis.MutationObserver ??= class {
  observe() {}
};

/** Whether markup says all of these, each a pattern. */
export function says(markup, ...patterns) {
  for (const pattern of patterns) assert.match(String(markup), pattern);
}

/** Frames of two pairs at three stops, with what a test needs changed. */
export function frames({ curves = {}, head = {}, orders = [0, 0.5, 1], ...more } = {}) {
  const still = { array: 1, orders: [0] };
  const meta = { curves, head: { source: "A", ...head }, maps: { "pca/raw": still, "pca/frft": still } };
  return {
    meta,
    orders,
    pairs: 2,
    domains: ["A", "B"],
    classes: ["wood", "steel"],
    domain: [0, 1],
    label: [0, 1],
    confidence: new Uint8Array(2 * orders.length),
    kind: meta.head.kind ?? "moved",
    headless: meta.head.kind === "features",
    labelled: true,
    columns: {},
    answered: null,
    learned: meta.head.learned_order ?? Number.NaN,
    source: meta.head.source,
    stop: (p) => orders.reduce((best, o, i) => (Math.abs(o - p) < Math.abs(orders[best] - p) ? i : best), 0),
    ...more,
  };
}
