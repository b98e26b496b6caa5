/** Chapter 2: what heads lose on another domain, split into sensor, scene and other objects; and on the page's own set. */

import { provenance } from "../shared/provenance.js";
import { each, escaped, percent } from "../shared/text.js";

const TERMS = [
  ["sensor", "another sensor"],
  ["scene", "another scene"],
  ["interplay", "both at once"],
  ["objects", "other objects"],
];

const signed = (points) => {
  const whole = Math.round(points);
  return whole ? `${whole > 0 ? "+" : "−"}${Math.abs(whole)}` : "0";
};
const range = (low, high) => `95 % interval ${low.toFixed(0)} to ${high.toFixed(0)} points`;

/** Rows from home to away: {name, low, high, text, title, ends}; `ends` are shares, a bar lies between them. */
export function rowsOf(loss) {
  let left = loss.home[0];
  const whole = (name, [share, low, high]) => ({
    name,
    ends: [0, share / 100],
    text: `${share.toFixed(0)}\u00a0%`,
    title: range(low, high),
  });
  const lost = TERMS.filter(([term]) => loss[term].some((v) => v)).map(([term, name]) => {
    const [points, low, high] = loss[term];
    const ends = [(left - points) / 100, left / 100];
    left -= points;
    return {
      name,
      ends: ends.toSorted((a, b) => a - b),
      text: signed(-points),
      title: range(-high, -low),
      lost: points > 0,
    };
  });
  return [whole("at home", loss.home), ...lost, whole("away", loss.away)];
}

/** @param {any} one */
const row = ({ name, ends, text, title, kind = "" }) =>
  `<div title="${title}"><dt>${name}</dt><dd><span class="scale" style="--from:${ends[0]};--to:${ends[1]}"><i class="${kind}"></i></span><output>${text}</output></dd></div>`;

/** The loss by one reading as bars, and where it comes from. `dots`: 0 as printed, 1 filled. */
export function splitHtml({ split, presses }, reading, dots) {
  const rows = each(rowsOf(split.loss[reading][dots]), ({ lost, ...one }) =>
    row({ ...one, kind: lost === undefined ? "" : lost ? "lost" : "gained" }),
  );
  const pairs = `mean of ${split.sources} sources and their seven other domains, ${Math.max(...presses[reading])} twins${dots ? ", dots filled" : ""}`;
  return `<dl>${rows}</dl>${provenance({ head: split.head, source: "one domain each", pairs })}`;
}

/** What is known of another domain, in the server's words, and what a bar is called. */
export const OWN_ROWS = { home: "at home", nothing: "away", pictures: "away, pictures", labels: "away, labels" };

/** What the loaded head reads right on the page's own set: `found` has, by the name of a row, the server's record, or
 * {problem}; a row that is not there yet is on its way. */
export function ownHtml(found) {
  const rows = Object.entries(OWN_ROWS).map(([key, name]) => {
    const { accuracy, low, high, problem } = found[key] ?? {};
    const text = problem ? "–" : accuracy === undefined ? "…" : percent(accuracy);
    const title = problem ?? (accuracy === undefined ? "" : `95 % interval ${percent(low)} to ${percent(high)}`);
    return row({ name, ends: [0, accuracy ?? 0], text, title: escaped(title) });
  });
  const known = ["pictures", "labels"].flatMap((key) => found[key]?.known ?? []);
  const away = ["nothing", "pictures", "labels"].map((key) => found[key]).find((one) => one?.domains);
  const names = Object.keys(away?.domains ?? {});
  const unknown = [...new Set(Object.values(found).flatMap(({ problem }) => problem ?? []))];
  const from = away
    ? provenance({
        head: "the loaded head",
        source: away.source,
        pairs: `away is ${names.join(", ")}, ${away.pairs.toLocaleString("en-US")} pairs`,
        known: ["nothing", ...known].join("; "),
      })
    : "";
  return `<dl>${rows.join("")}</dl>${each(unknown, (one) => `<p class="hint">Not known: ${escaped(one)}</p>`)}${from}`;
}
