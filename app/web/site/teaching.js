/** Teaching from a visitor's labelled pairs, as `omnivat/head/teach.py` does it. No DOM here. */

import { IMAGES, imagesOf } from "../shared/images.js";
import { solved, triangle, unfolded } from "./logistic.js";
import { Refused } from "./refusal.js";
import { best, dot, rowOf, softmax, unit } from "./tensors.js";

const [LOGISTIC, MEAN, NEIGHBOUR, DIRECTIONS] = [
  "logistic regression",
  "nearest class mean",
  "nearest neighbour",
  "class directions",
];
const MOST_LESSONS = 60;
const LONGEST_LABEL = 40;
const TOTAL = 20; // weight of a class's lessons together, in pairs
const SHARPNESS = 10; // of cosines

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

class Work {
  /** @type {{row: Float64Array, label: number}[]} of the head's own training */
  source = [];
  /** @type {string[]} */
  methods = [];
  /** @type {Float64Array[]} of the lessons */
  rows = [];
  /** @type {any[]} of the lessons, at F̂ */
  means = [];
  /** @type {number[]} what is predicted before */
  before = [];

  /** room: {head, lessons: [{label, pair}], known, run(pair, head)} */
  constructor({ head, lessons, known, run }) {
    this.head = head;
    this.lessons = lessons;
    this.known = known;
    this.run = run;
    this.lower = null;
    this.start = null;
    const names = this.lessons.map(({ label }) => label);
    this.classes = [...new Set([...this.head.classes, ...names])];
    this.labels = names.map((name) => this.classes.indexOf(name));
  }

  async prepared() {
    this.source = await trainingRows(this);
    this.methods = this.source.length ? [LOGISTIC, MEAN, NEIGHBOUR, DIRECTIONS] : [DIRECTIONS, MEAN, NEIGHBOUR];
    for (const { pair } of this.lessons) {
      const out = await this.run(pair);
      const there = imagesOf(pair);
      this.rows.push(standing(out, there));
      const hats = there.map((name) => unit(rowOf(out[there.length > 1 ? `${name}_f_hat` : `${name}_alone`], 0)));
      this.means.push(hats[0].map((_, i) => hats.reduce((sum, hat) => sum + hat[i], 0) / hats.length));
      this.before.push(best(said(out, there)));
    }
    return this;
  }

  /** Leave each lesson out and predict it by every method. */
  async report() {
    /** @type {Record<string, any[]>} */
    const found = Object.fromEntries(this.methods.map((name) => [name, []]));
    for (const out of this.lessons.keys())
      for (const name of this.methods) found[name].push(await this.predicted(name, out));
    const right = (name, but = -1) => found[name].filter((label, i) => i !== but && label === this.labels[i]).length;
    const after = this.labels.map((_, out) => found[this.best((name) => right(name, out))][out]);
    const judged = this.lessons.map(({ label }, i) => ({
      label,
      before: this.head.classes[this.before[i]],
      after: this.classes[after[i]],
    }));
    const count = (when) => judged.filter((one) => one[when] === one.label).length;
    return {
      judged,
      right: { before: count("before"), after: count("after") },
      method: this.best((name) => right(name)),
      methods: Object.fromEntries(this.methods.map((name) => [name, right(name)])),
    };
  }

  /** The best method; the first one unless another is better by more than chance. */
  best(right) {
    const top = this.methods.reduce((one, name) => (right(name) > right(one) ? name : one));
    return right(top) - right(this.methods[0]) > Math.sqrt(this.lessons.length) / 2 ? top : this.methods[0];
  }

  async predicted(method, out) {
    if (method === DIRECTIONS) {
      const { pair } = this.lessons[out];
      const found = await this.run(pair, this.directed(out));
      return best(said(found, imagesOf(pair)));
    }
    if (method === LOGISTIC) {
      const { weights, present } = this.logistic(out);
      const row = this.lower[this.source.length + out];
      return present[best(present.map((label) => dot(row, weights[label]) + weights[label].at(-1)))];
    }
    const { rows, owner } = this.deciding(method, out);
    return owner[best(rows.map((row) => dot(row, this.rows[out])))];
  }

  /** The regression without one lesson: weights (K, R + 1) in the basis, and the classes that it saw. */
  logistic(out) {
    const all = [...this.source.map(({ row }) => row), ...this.rows];
    this.lower ??= triangle(all);
    const labels = [...this.source.map(({ label }) => label), ...this.labels];
    const each = this.lessons.length / new Set(this.labels).size;
    const times = Math.trunc(Math.min(TOTAL, Math.max(2, Math.floor(TOTAL / each))));
    const counts = labels.map((_, i) => (i < this.source.length ? 1 : i === this.source.length + out ? 0 : times));
    const problem = { rows: this.lower, labels, counts, classes: this.classes.length };
    this.start = solved(problem, this.start);
    const wide = this.lower.length + 1;
    const weights = this.classes.map((_, k) => this.start.slice(k * wide, (k + 1) * wide));
    const present = [...new Set(labels.filter((_, i) => counts[i]))].sort((a, b) => a - b);
    return { weights, present, all };
  }

  /** Rows, biases and classes without one lesson: the largest score decides. */
  deciding(method, out = -1) {
    if (method === LOGISTIC) {
      const { weights, present, all } = this.logistic(out);
      const own = present.map((label) => weights[label]);
      return {
        rows: unfolded(
          own.map((row) => row.slice(0, -1)),
          this.lower,
          all,
        ),
        bias: own.map((row) => row.at(-1)),
        owner: present,
      };
    }
    const kept = this.rows.map((row, i) => ({ row, label: this.labels[i] })).filter((_, i) => i !== out);
    const taught = new Set(kept.map(({ label }) => label));
    let some = [...kept, ...this.source.filter(({ label }) => !taught.has(label))];
    if (method === MEAN) {
      const names = [...new Set(some.map(({ label }) => label))].sort((a, b) => a - b);
      some = names.map((label) => ({
        label,
        row: sum(some.filter((one) => one.label === label).map(({ row }) => row)),
      }));
    }
    const rows = some.map(({ row }) => unit(row).map((value) => SHARPNESS * value));
    return { rows, bias: rows.map(() => 0), owner: some.map(({ label }) => label) };
  }

  /** The head with the means of the lessons added to its directions. */
  directed(out = -1) {
    const { head, classes } = this;
    const wide = this.means[0].length;
    const own = classes.map((_, k) => (head.directions[k] ? unit(head.directions[k]) : new Float64Array(wide)));
    this.means.forEach((mean, i) => i !== out && own[this.labels[i]].forEach((_, at, row) => (row[at] += mean[at])));
    const directions = own.map((row) => Array.from(unit(row), (value) => head.scale * value));
    return { ...head, classes, directions };
  }

  made(method) {
    const found = this.directed();
    return method === DIRECTIONS ? { ...found, method } : { ...found, ...this.deciding(method), method };
  }
}

const sum = (rows) => rows[0].map((_, i) => rows.reduce((total, row) => total + row[i], 0));
const said = (out, there) => rowOf(out[there.length > 1 ? "p_fused" : `p_${there[0]}`], 0);

/** A head that predicts as the lessons teach: by the best method, or the first one with too few lessons. */
export async function taught(room) {
  const work = await new Work(room).prepared();
  return work.made(missing(room.lessons) ? work.methods[0] : (await work.report()).method);
}

/** The report of teaching, and the taught head. */
export async function headOf(room) {
  const lacking = missing(room.lessons);
  if (lacking) throw new Refused(lacking);
  const work = await new Work(room).prepared();
  const report = await work.report();
  return { report, made: work.made(report.method) };
}
