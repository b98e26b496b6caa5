/** Chapter 2: what heads lose on another domain, split into sensor, scene and other objects. */

import { provenance } from "../shared/provenance.js";
import { each } from "../shared/text.js";

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

/** The loss by one reading as bars, and where it comes from. `dots`: 0 as printed, 1 filled. */
export function splitHtml({ split, presses }, reading, dots) {
  const rows = each(rowsOf(split.loss[reading][dots]), ({ name, ends, text, title, lost }) => {
    const kind = lost === undefined ? "" : lost ? ' class="lost"' : ' class="gained"';
    return `<div title="${title}"><dt>${name}</dt><dd><span class="scale" style="--from:${ends[0]};--to:${ends[1]}"><i${kind}></i></span><output>${text}</output></dd></div>`;
  });
  const pairs = `mean of ${split.sources} sources and their seven other domains, ${Math.max(...presses[reading])} twins${dots ? ", dots filled" : ""}`;
  return `<dl>${rows}</dl>${provenance({ head: split.head, source: "one domain each", pairs })}`;
}
