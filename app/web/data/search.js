/** The curve of the search for p, from `metrics.json`. No DOM here. */

import { escaped } from "../shared/text.js";

const WIDTH = 420;
const HEIGHT = 120;
const LEFT = 34;

/** found: {orders, score, spread, start}; score is the error on source pairs left out. */
export function searched(found) {
  const points = (found?.orders ?? [])
    .map((p, i) => [p, found.score?.[i], found.spread?.[i] ?? 0])
    .filter((point) => point.every(Number.isFinite))
    .sort((a, b) => a[0] - b[0]);
  if (points.length < 2) return "";
  const top = Math.max(...points.map(([, v, s]) => v + s));
  const x = (p) => (LEFT + (WIDTH - LEFT - 6) * p).toFixed(1);
  const y = (v) => (HEIGHT - 18 - (HEIGHT - 26) * (v / top)).toFixed(1);
  const line = points.map(([p, v], i) => `${i ? "L" : "M"}${x(p)} ${y(v)}`).join("");
  const bars = points.map(([p, v, s]) => `<path d="M${x(p)} ${y(Math.max(0, v - s))}V${y(v + s)}"/>`).join("");
  const best = points.reduce((a, b) => (b[1] < a[1] ? b : a));
  const ticks = [0, 0.5, 1].map((p) => `<text x="${x(p)}" y="${HEIGHT - 4}">${p}</text>`).join("");
  return `<figure class="searched"><figcaption>The search for p: error on pairs of the source that were left out</figcaption>
    <svg viewBox="0 0 ${WIDTH} ${HEIGHT}" role="img" aria-label="Error against p; lowest, ${best[1].toFixed(2)}, at p = ${best[0].toFixed(2)}"><path class="axis" d="M${LEFT} 4V${HEIGHT - 18}H${WIDTH - 6}"/><text x="${LEFT - 4}" y="12" class="end">${top.toFixed(1)}</text><text x="${LEFT - 4}" y="${HEIGHT - 18}" class="end">0</text>${ticks}<path class="line" d="${line}"/>${bars}</svg>
    <p class="hint">A classifier at each point; bars are standard errors over pairs. The gradient started from p = ${Number(found.start).toFixed(3)}. ${escaped(found.note ?? "")}</p></figure>`;
}
