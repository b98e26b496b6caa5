/** Lists of numbers. No DOM here. */

/** @param {number[]} all */
export const sum = (all) => all.reduce((a, b) => a + b, 0);
/** @param {number[]} all */
export const mean = (all) => sum(all) / all.length;
/** Return the lowest and the highest finite value. @param {number[]} all @returns {[number, number]} */
export const ends = (all) => {
  const known = all.filter(Number.isFinite);
  return [Math.min(...known), Math.max(...known)];
};
/** Return the class of the largest probability, its index and the probability.
 * @param {string[]} classes @param {number[]} row */
export const best = (classes, row) => {
  const share = Math.max(...row);
  const at = row.indexOf(share);
  return { at, label: classes[at], share };
};
