/** Teaching from a visitor's labelled pairs, as `omnivat/head/teach.py` does it. No DOM here. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { Refused } from "./refusal.js";
import { best, dot, rowOf, softmax, unit } from "./tensors.js";

const MOST_LESSONS = 60;
const LONGEST_LABEL = 40;
const WEIGHT = 10; // of a class's lessons together, in training pairs
const SHARPNESS = [0.5, 50]; // least and most, of scores
const PARTS = ["training pairs and lessons", "lessons alone"];

/** The labelled pairs of a question. */
export function lessonsIn({ lessons = [] }) {
  const given = lessons ?? [];
  if (!Array.isArray(given)) throw new Refused("lessons has to be a list of pairs with a label each.");
  if (given.length > MOST_LESSONS)
    throw new Refused(
      `${given.length} labelled pairs were sent and at most ${MOST_LESSONS} are taken here; train with \`python -m omnivat train\` instead.`,
    );
  for (const { vis, tac, label } of given) {
    const length = typeof label === "string" ? label.trim().length : 0;
    if (!length || length > LONGEST_LABEL)
      throw new Refused(`A label is '${label}'; give a name of 1 to ${LONGEST_LABEL} letters.`);
    const own = vis?.startsWith("image:") && tac?.startsWith("image:");
    if (vis && tac && vis !== tac && !own)
      throw new Refused(
        `The photo and the touch labelled '${label}' come from different pairs; label pairs of two pictures of one object.`,
      );
  }
  return given;
}

/** The readings of a head with taught rows: a class has the largest score of its rows. */
export function scoresOf({ rows, bias, owner, classes }, out, there) {
  const part = (name, at) => {
    const own = out[`${name}_standing`].values;
    const from = name === "vis" ? 0 : own.length;
    return dot(own, rows[at].subarray(from, from + own.length));
  };
  const shares = (score) => {
    const logits = classes.map(() => Number.NEGATIVE_INFINITY);
    owner.forEach((label, at) => (logits[label] = Math.max(logits[label], score(at) + bias[at])));
    return softmax(logits);
  };
  const alone = Object.fromEntries(there.map((name) => [name, shares((at) => 2 * part(name, at))]));
  if (there.length === 1) return { fused: alone[there[0]], ...alone };
  const fused = shares((at) => part("vis", at) + part("tac", at));
  return { fused, ...alone, vis_branch: alone.vis, tac_branch: alone.tac };
}

function missing(lessons) {
  const counts = {};
  for (const { label } of lessons) counts[label] = (counts[label] ?? 0) + 1;
  if (Object.values(counts).filter((count) => count >= 2).length >= 2) return "";
  const there = Object.entries(counts).map(([label, count]) => `${label} ${count}`);
  return `Label two or more pairs of each of two or more classes first, of different objects; there are: ${there.join(", ") || "none yet"}.`;
}

const known = new WeakMap(); // training embeddings -> their rows

/** The training pairs as rows {row, label}; none for a head without them. */
async function trainingRows({ known: kept, run }) {
  if (!kept?.labels || IMAGES.some((name) => !kept[`${name}_lengths`])) return [];
  if (known.has(kept)) return known.get(kept);
  const found = [];
  for (const [at, label] of kept.labels.values.entries()) {
    const raw = (name) => rowOf(kept[name], at).map((value) => value * kept[`${name}_lengths`].values[at]);
    const out = await run({ vis: raw("vis"), tac: raw("tac") });
    found.push({ row: standing(out, IMAGES), label });
  }
  known.set(kept, found);
  return found;
}

/** VIS and TAC side by side; the part of a missing image is zero. */
function standing(out, there) {
  const width = out.vis_standing.values.length;
  const row = new Float64Array(2 * width);
  for (const name of there) row.set(out[`${name}_standing`].values, name === "vis" ? 0 : width);
  return row;
}

/** The inverse of a positive definite matrix, by Cholesky's factor. */
export function inverted(matrix) {
  const size = matrix.length;
  const lower = matrix.map(() => new Float64Array(size));
  for (let i = 0; i < size; i++)
    for (let j = 0; j <= i; j++) {
      const rest = matrix[i][j] - dot(lower[i].subarray(0, j), lower[j]);
      lower[i][j] = i === j ? Math.sqrt(rest) : rest / lower[j][j];
    }
  const roots = lower.map(() => new Float64Array(size)); // row i: column i of the factor's inverse
  for (let i = 0; i < size; i++) {
    roots[i][i] = 1 / lower[i][i];
    for (let j = i + 1; j < size; j++)
      roots[i][j] = -dot(lower[j].subarray(i, j), roots[i].subarray(i, j)) / lower[j][j];
  }
  return roots.map((row, i) =>
    Float64Array.from(roots, (other, j) => dot(row.subarray(Math.max(i, j)), other.subarray(Math.max(i, j)))),
  );
}

/** The ridge regression of one-hot labels on counted rows: `weights` (K, W), `bias` (K) and `apart`, the scores (L, K)
 * of each of the first `lessons` rows by the regression without it. See `ridge` in omnivat/head/teach.py. */
export function ridge(rows, labels, counts, classes, lessons) {
  const products = rows.map((row, i) => rows.slice(0, i + 1).map((other) => dot(row, other)));
  const inverse = inverted(
    rows.map((_, i) =>
      Float64Array.from(rows, (_, j) => products[Math.max(i, j)][Math.min(i, j)] + 1 + (i === j ? 1 / counts[i] : 0)),
    ),
  );
  const target = (i, k) => Number(labels[i] === k);
  const shares = Array.from({ length: classes }, (_, k) =>
    inverse.map((row) => sum(row.filter((_, j) => target(j, k)))),
  );
  const weights = shares.map((share) => {
    const weight = new Float64Array(rows[0].length);
    rows.forEach((row, i) => row.forEach((value, at) => (weight[at] += share[i] * value)));
    return weight;
  });
  const apart = labels
    .slice(0, lessons)
    .map((_, i) => shares.map((share, k) => target(i, k) - share[i] / inverse[i][i]));
  return { weights, bias: shares.map(sum), apart };
}

/** t with the least squared error of (1 - t) both + t lessons, of errors (L, K). */
export function shareOf(both, lessons) {
  const pairs = both.flatMap((row, i) => row.map((error, k) => [error, error - lessons[i][k]]));
  const top = sum(pairs.map(([error, apart]) => error * apart));
  return Math.min(1, Math.max(0, top / Math.max(1e-12, sum(pairs.map(([, apart]) => apart * apart)))));
}

/** The factor of scores (L, K) whose softmax has the least log loss, with one more lesson of every class alike. */
export function sharpness(scores, labels) {
  let [low, high] = SHARPNESS;
  for (let turn = 0; turn < 40; turn++) {
    const factor = (low + high) / 2;
    const means = scores.map((row) => dot(softmax(row.map((score) => factor * score)), row));
    const slope = sum(
      means.map((mean, i) => mean - scores[i][labels[i]] + (mean - sum(scores[i]) / scores[i].length) / scores.length),
    );
    if (slope < 0) low = factor;
    else high = factor;
  }
  return high;
}

const sum = (values) => values.reduce((total, value) => total + value, 0);
const blended = (share, both, lessons) => both.map((value, i) => (1 - share) * value + share * lessons[i]);

/** The two maps of lessons {label, pair} and training pairs, and what each says of the lessons without them. */
class Work {
  /** @type {string[]} */
  before = [];
  /** @type {Float64Array[][]} of each lesson's images, unit rows at F̂ */
  hats = [];
  /** @type {ReturnType<typeof ridge>[]} */
  maps = [];
  /** @type {number[][][]} of each map and lesson */
  errors = [];
  /** @type {number[]} classes with pairs */
  present = [];
  share = 0; // of the lessons alone

  /** room: {head, lessons: [{label, pair}], known, run(pair, head)} */
  constructor(room) {
    this.room = room;
    this.head = room.head;
    const names = room.lessons.map(({ label }) => label);
    this.classes = [...new Set([...this.head.classes, ...names])];
    this.labels = names.map((name) => this.classes.indexOf(name));
  }

  async prepared() {
    const { labels, classes } = this;
    const source = await trainingRows(this.room);
    const outs = [];
    for (const { pair } of this.room.lessons) outs.push({ out: await this.room.run(pair), there: imagesOf(pair) });
    this.before = outs.map(({ out, there }) => this.head.classes[best(said(out, there))]);
    this.hats = outs.map(({ out, there }) =>
      there.map((name) => unit(rowOf(out[there.length > 1 ? `${name}_f_hat` : `${name}_alone`], 0))),
    );
    const rows = outs.map(({ out, there }) => standing(out, there));
    const weight = Math.max(1, (WEIGHT * new Set(labels).size) / labels.length);
    this.maps = [source, source.filter(({ label }) => !labels.includes(label))].map((some) =>
      ridge(
        [...rows, ...some.map(({ row }) => row)],
        [...labels, ...some.map(({ label }) => label)],
        [...rows.map(() => weight), ...some.map(() => 1)],
        classes.length,
        rows.length,
      ),
    );
    this.present = [...new Set([...source.map(({ label }) => label), ...labels])].sort((a, b) => a - b);
    this.errors = this.maps.map(({ apart }) =>
      apart.map((row, i) => row.map((score, k) => Number(labels[i] === k) - score)),
    );
    this.share = missing(this.room.lessons) ? 0 : shareOf(this.errors[0], this.errors[1]);
    return this;
  }

  best = (scores) => this.present[best(this.present.map((k) => scores[k]))];

  /** Each lesson before, and after teaching by the others; the share is chosen without it, too. */
  report() {
    const { labels, classes, before, maps } = this;
    const after = labels.map((_, out) => {
      const [both, alone] = this.errors.map((errors) => errors.filter((_, i) => i !== out));
      const share = shareOf(both, alone);
      return classes[this.best(blended(share, maps[0].apart[out], maps[1].apart[out]))];
    });
    const judged = this.room.lessons.map(({ label }, i) => ({ label, before: before[i], after: after[i] }));
    const right = (when) => judged.filter((one) => one[when] === one.label).length;
    const parts = maps.map(({ apart }) => apart.filter((row, i) => this.best(row) === labels[i]).length);
    return {
      judged,
      right: { before: right("before"), after: right("after") },
      share: Math.round(1e4 * this.share) / 1e4,
      parts: Object.fromEntries(PARTS.map((name, i) => [name, parts[i]])),
    };
  }

  /** The taught head: a row and a bias of each class that has pairs, and directions of new classes. */
  made() {
    const { head, classes, labels, share, present } = this;
    const [both, alone] = this.maps;
    const sharp = sharpness(
      both.apart.map((row, i) => blended(share, row, alone.apart[i])),
      labels,
    );
    const directions = classes.map((_, k) => {
      if (head.directions[k]) return head.directions[k];
      const hats = this.hats.filter((_, i) => labels[i] === k).flat();
      const mean = unit(hats[0].map((_, at) => sum(hats.map((hat) => hat[at])) / hats.length));
      return Array.from(mean, (value) => head.scale * value);
    });
    return {
      ...head,
      classes,
      directions,
      share,
      rows: present.map((k) => blended(share, both.weights[k], alone.weights[k]).map((value) => sharp * value)),
      bias: blended(share, both.bias, alone.bias)
        .filter((_, k) => present.includes(k))
        .map((value) => sharp * value),
      owner: present,
    };
  }
}

const said = (out, there) => rowOf(out[there.length > 1 ? "p_fused" : `p_${there[0]}`], 0);

/** A head that predicts as the lessons teach. */
export const taught = async (room) => (await new Work(room).prepared()).made();

/** The report of teaching, and the taught head. */
export async function headOf(room) {
  const lacking = missing(room.lessons);
  if (lacking) throw new Refused(lacking);
  const work = await new Work(room).prepared();
  return { report: work.report(), made: work.made() };
}
