/** Chapter 2: what heads lose on another domain, split into sensor, scene and other objects; and on the page's own
 * set. */

import { provenance } from "../shared/provenance.js";
import { TABLES } from "../shared/tables.js";
import { barOf, barRow } from "./bars.js";
import { grouped, html, interval, percent } from "./root.js";

const TERMS = [
  ["sensor", "another sensor"],
  ["scene", "another scene"],
  ["interplay", "both together"],
  ["objects", "other objects"],
];

/** A bar from one share to another.
 * @typedef {{name: string, ends: number[], text: string, title: string, kind?: string}} Bar */

const signed = (/** @type {number} */ points) => (points ? `${points > 0 ? "+" : "−"}${Math.abs(points)}` : "0");
const range = (/** @type {number} */ low, /** @type {number} */ high) =>
  `95 % interval: ${low.toFixed(0)} to ${high.toFixed(0)} points`;

/** Return bars of the accuracy in the training domain and in a new one, and between them those of each loss or gain.
 * @param {Record<string, Interval>} loss
 * @returns {Bar[]} */
export function barsOf(loss) {
  let left = loss.home[0];
  const whole = (/** @type {string} */ name, /** @type {Interval} */ [share, low, high]) => ({
    name,
    ends: [0, share / 100],
    text: `${share.toFixed(0)}\u00a0%`,
    title: range(low, high),
  });
  const lost = TERMS.filter(([term]) => loss[term].some((v) => v)).map(([term, name]) => {
    const [points, low, high] = loss[term];
    const ends = [(left - points) / 100, left / 100];
    const before = Math.round(left);
    left -= points;
    return {
      name,
      ends: ends.toSorted((a, b) => a - b),
      text: signed(Math.round(left) - before), // rounded so that the figures add up
      title: range(-high, -low),
      kind: points > 0 ? "lost" : "gained",
    };
  });
  return [whole("training domain", loss.home), ...lost, whole("new domain", loss.away)];
}

/** @param {Bar[]} bars */
const list = (bars) =>
  html`${bars.map(({ name, ends, text, title, kind }) => barRow(name, barOf(ends, kind), text, { title }))}`;

/** Return bars that split the loss of one reading, with their provenance. `look`: 0 dots as printed, 1 filled, 2 by
 * relief.
 * @param {Pick<Twins, "split" | "presses">} twins @param {Input} reading @param {number} look */
export function splitHtml({ split, presses }, reading, look) {
  const what = `${reading === "touch" ? "presses" : "objects"}${["", " with filled dots", " by relief"][look]}`;
  const pairs =
    `${Math.max(...presses[reading])} ${what} in the seven others; ` +
    `each figure is the mean over ${split.sources} training domains`;
  return html`${list(barsOf(split.loss[reading][look]))}
    ${provenance({ head: split.head, source: "one domain each", pairs, known: "nothing from the new domain" })}`;
}

/** The rungs with a bar of the page's own set. */
export const OWN_ROWS = TABLES.rungs.filter(({ bar }) => bar);

/** Return what the loaded head reads right on the page's own set, by what is known; a row that is not there yet is on
 * its way.
 * @param {Scene["known"]} known */
export function ownHtml(known) {
  const rows = OWN_ROWS.map(({ id, bar: name = "" }) => {
    const { accuracy, low = 0, high = 0, problem } = known[id] ?? {};
    const text = problem ? "–" : accuracy === undefined ? "…" : percent(accuracy);
    const title = problem ?? (accuracy === undefined ? "" : interval(low, high));
    return { name, ends: [0, accuracy ?? 0], text, title };
  });
  const others = OWN_ROWS.filter(({ home }) => !home);
  const away = others.map(({ id }) => known[id]).find((record) => record?.domains);
  const missing = [...new Set(Object.values(known).flatMap(({ problem }) => problem ?? []))];
  const from =
    away &&
    provenance({
      head: "the loaded head",
      source: away.source ?? "",
      pairs: `${grouped(away.pairs ?? 0)} pairs of ${Object.keys(away.domains ?? {}).join(", ")}`,
      known: others.flatMap(({ id, brief }) => brief ?? known[id]?.known ?? []).join(", then "),
    });
  return html`${list(rows)}${missing.map((problem) => html`<p class="hint">A bar is missing: ${problem}</p>`)}
    ${from && from}`;
}
