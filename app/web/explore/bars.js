/** Bars of shares, one below the other. */

import { sum } from "../shared/numbers.js";
import { html } from "./root.js";

/** Return a scale with an interval and its mean; a line at chance.
 * @param {Share | undefined} share @param {number} chance */
export const scaleOf = (share, chance) =>
  html`<span class="scale" style="--chance:${chance}">${
    share &&
    html`<i class="range" style="--low:${share.low};--high:${share.high}"></i>
      <i class="mean" style="--share:${share.share}"></i>`
  }</span>`;

/** Return what accuracy hides where one class is larger than others, of a confusion matrix: the share of the largest
 * class, the mean over classes of the share right, and whether the largest class has 1.5 times the mean size.
 * @param {number[][]} counts */
export function balance(counts) {
  const sizes = counts.map(sum);
  const whole = sum(sizes) || 1;
  const recalls = counts.flatMap((row, k) => (sizes[k] ? [row[k] / sizes[k]] : []));
  const always = Math.max(...sizes) / whole;
  const balanced = sum(recalls) / (recalls.length || 1);
  return { always, balanced, uneven: always * recalls.length >= 1.5 };
}

/** Return a scale with a bar from one share to another. @param {number[]} ends */
export const barOf = ([from, to], kind = "") =>
  html`<span class="scale" style="--from:${from};--to:${to}"><i class="bar ${kind}"></i></span>`;

/** Return a row of bars.
 * @param {string} name @param {Html} scale @param {Markup} figure
 * @param {{kind?: string, title?: Markup, more?: Markup | false}} [about] */
export const barRow = (name, scale, figure, { kind = "", title = "", more = "" } = {}) =>
  html`<div class="bar-row ${kind}" data-domain="${name}" title="${title}"><span class="who">
    ${name.replace(/-sim$/, "")}${more}</span>${scale}<output>${figure}</output></div>`;
