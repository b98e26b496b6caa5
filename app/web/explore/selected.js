/** Selected points in the address: runs of neighbouring numbers, as distances in base 36. */

const MOST = 4000; // letters; a longer selection is left out of the address

/** @param {Iterable<number>} points */
export function packed(points) {
  const runs = [];
  for (const point of [...points].sort((a, b) => a - b)) {
    const last = runs.at(-1);
    if (last && last[1] === point - 1) last[1] = point;
    else runs.push([point, point]);
  }
  let before = 0;
  const text = runs.map(([from, to]) => {
    const gap = (from - before).toString(36);
    before = to;
    return to > from ? `${gap}.${(to - from).toString(36)}` : gap;
  });
  return text.join("-").length > MOST ? "" : text.join("-");
}

/** The points of a packed text below `count`; what is not such a text has none.
 * @param {string} text @param {number} count */
export function unpacked(text, count) {
  const points = [];
  let at = 0;
  for (const run of text ? text.split("-") : []) {
    const [gap, more = 0] = run.split(".").map((part) => Number.parseInt(part, 36));
    if (!(gap >= 0 && more >= 0) || at + gap + more >= count) return points;
    at += gap;
    for (let i = 0; i <= more; i++) points.push(at + i);
    at += more;
  }
  return points;
}
