/** Many pairs at once: a table of predictions with guess marks, and a CSV. */

import { ask, Refusal, refused, sendImage } from "../shared/api.js";
import { csv as written } from "../shared/csv.js";
import { IMAGES, imagesOf } from "../shared/images.js";
import { save } from "../shared/save.js";
import { escaped, percent } from "../shared/text.js";
import { paired } from "./pairing.js";
import { sent } from "./sent.js";
import { tally } from "./tally.js";
import { best, READINGS, said, unlike } from "./verdict.js";

const AT_ONCE = 12; // pairs of one request
const LARGEST = 20e6;
const plural = (n, what) => `${n.toLocaleString("en-US")} ${what}${n === 1 ? "" : "s"}`;

/** Upload a file; of many, the page keeps no preview. */
export async function upload(file, signal) {
  if (file.size > LARGEST)
    throw new Refusal(
      `'${file.name}' has ${(file.size / 1e6).toFixed(0)} MB; the limit is 20 MB. Scale it down and try again.`,
    );
  const { ref, width, height, preview } = await sendImage(file, file.name, signal);
  sent.set(ref, { name: file.name, width, height, ...(signal ? { file } : { preview }) });
  return ref;
}

export class Many {
  /** on: open(pair), labels(pairs) to count and teach, classes() of the head, lessons(). */
  constructor(box, on) {
    this.box = box;
    this.on = on;
    this.stopped = null;
    this.rows = [];
    box.onclick = ({ target }) => {
      const row = target.closest("tr[data-row]");
      if (row) on.open(this.rows[+row.dataset.row]);
      if (target.matches(".stop")) this.stopped?.abort();
      if (target.matches(".csv")) save("pairs.csv", csv(this.rows));
      if (target.matches(".labels")) on.labels(this.rows.filter(({ label, said: found }) => label && found));
      if (target.matches(".close")) this.close();
    };
  }

  close() {
    this.stopped?.abort();
    this.rows = [];
    this.box.hidden = true;
  }

  /** files: [{path, file}]. */
  async take(files) {
    this.close();
    const mine = (this.stopped = new AbortController());
    const table = files.find(({ path }) => /\.csv$/i.test(path));
    const { pairs, alone } = paired(files, table ? await table.file.text() : "", await this.on.classes());
    this.box.hidden = false;
    const left = alone.length ? ` ${plural(alone.length, "picture")} left out: no partner by name.` : "";
    if (!pairs.length) {
      this.show(
        table
          ? "The CSV names none of these pictures. Drop it together with them; it needs the columns vis and tac."
          : `No pair was recognised among ${plural(files.length, "file")}. Name them x_vis and x_tac, or add a CSV with the columns vis and tac.`,
      );
      return;
    }
    let done = 0;
    const began = Date.now();
    try {
      for (let at = 0; at < pairs.length; at += AT_ONCE) {
        const some = pairs.slice(at, at + AT_ONCE);
        for (const pair of some) {
          this.progress(++done, pairs.length, (Date.now() - began) / 1000);
          await this.send(pair, mine.signal);
        }
        await this.predict(
          some.filter((pair) => !pair.problem),
          mine.signal,
        );
        this.rows.push(...some);
      }
      this.show(left);
    } catch (error) {
      if (mine.signal.aborted && this.stopped === mine)
        this.show(` Cancelled after ${this.rows.length} of ${plural(pairs.length, "pair")}.${left}`);
      refused(error, (sentence) => this.show(sentence));
    }
  }

  async send(pair, signal) {
    for (const modality of IMAGES) {
      if (!pair[modality]) continue;
      try {
        pair[modality] = await upload(pair[modality], signal);
      } catch (error) {
        refused(error, (sentence) => (pair.problem = sentence));
        signal.throwIfAborted();
        pair[modality] = null;
      }
    }
  }

  async predict(pairs, signal) {
    if (!pairs.length) return;
    const asked = pairs.map(({ vis, tac }) => ({ vis, tac }));
    const found = await ask("many", { pairs: asked, ...this.on.lessons() }, signal);
    found.pairs.forEach((one, i) =>
      Object.assign(pairs[i], one, { classes: found.classes, said: said(found.classes, one.readings) }),
    );
  }

  /** Another profile: predict all pairs again. */
  async again() {
    const there = this.rows.filter(({ readings: read }) => read);
    if (!there.length) return;
    try {
      for (let at = 0; at < there.length; at += AT_ONCE)
        await this.predict(there.slice(at, at + AT_ONCE), this.stopped.signal);
      this.show("");
    } catch (error) {
      refused(error, (sentence) => this.show(sentence));
    }
  }

  progress(done, total, seconds) {
    const left = done > 1 ? ` About ${Math.ceil((seconds * (total - done + 1)) / (done - 1))} s left.` : "";
    this.box.innerHTML = `<div class="stand"><p>Reading pair ${done} of ${total}…${left}</p><div class="bar-of-epochs"><i style="width:${(100 * done) / total}%"></i></div><button type="button" class="stop">Cancel</button></div>`;
  }

  show(note) {
    const { rows } = this;
    this.box.innerHTML = rows.length
      ? tableHtml(rows, note)
      : `<div class="stand"><p role="status">${escaped(note)}</p><button type="button" class="close">Close</button></div>`;
  }
}

/** The pair's predictions under each reading: {title, label, share, guess}; without an image only the title.
 * @returns {any[]} */
function readings({ classes, readings: found, images }) {
  const given = imagesOf(found);
  return READINGS.map(([reading, title]) => {
    if (!found[reading] || (reading === "fused" && given.length < 2)) return { title };
    return { title, ...best(classes, found[reading]), guess: unlike(reading, given, images).length > 0 };
  });
}

function tableHtml(rows, note) {
  const read = rows.filter((row) => row.readings);
  const labelled = read.filter(({ label }) => label);
  const guesses = read.filter((row) => readings(row)[0].guess ?? readings(row).some(({ guess }) => guess)).length;
  const right = tally(labelled);
  const scores = READINGS.filter(([reading]) => right[reading]).map(
    ([reading, title]) => `${title.toLowerCase()} ${right[reading].right} of ${right[reading].of}`,
  );
  const lines = rows.map((row, i) => {
    if (!row.readings)
      return `<tr><th scope="row">${escaped(row.name)}</th><td colspan="4" class="wrong">${escaped(row.problem)}</td></tr>`;
    const cells = readings(row).map(({ label, share, guess }) => {
      if (!label) return "<td>–</td>";
      const mark = row.label ? (row.label === label ? ' class="right"' : ' class="wrong"') : "";
      return `<td${mark}>${escaped(label)}${guess ? "?" : ` <b>${percent(share)}</b>`}</td>`;
    });
    return `<tr data-row="${i}"><th scope="row"><button type="button" class="link">${escaped(row.name)}</button></th><td>${escaped(row.label || "–")}</td>${cells.join("")}</tr>`;
  });
  return `<header><h3>${plural(rows.length, "pair")}: ${plural(guesses, "guess").replace("guesss", "guesses")}</h3><span class="row">${labelled.length ? '<button type="button" class="labels">Count and teach them</button>' : ""}<button type="button" class="main csv">Save as CSV</button><button type="button" class="close">Close</button></span></header>
    <p class="hint" role="status">${scores.length ? `Right: ${scores.join(", ")}. ` : ""}“?” marks a guess: a picture unlike anything the head has seen. Choose a row to open its pair.${escaped(note)}</p>
    <div class="scroll" tabindex="0" role="group" aria-label="Your pairs and their predictions"><table><thead><tr><th scope="col">Pair</th><th scope="col">Label</th>${READINGS.map(([, title]) => `<th scope="col">${title}</th>`).join("")}</tr></thead><tbody>${lines.join("")}</tbody></table></div>`;
}

/** One line for each pair: label, and class, probability and guess of each reading. */
export function csv(rows) {
  const head = [
    "pair",
    "label",
    ...READINGS.flatMap(([reading]) => [reading, `${reading}_probability`, `${reading}_guess`]),
    "problem",
  ];
  const lines = rows.map((row) => [
    row.name,
    row.label,
    ...(row.readings ? readings(row) : READINGS.map(() => /** @type {any} */ ({}))).flatMap(
      ({ label = "", share, guess }) => [label, share === undefined ? "" : share.toFixed(4), guess ?? ""],
    ),
    row.problem ?? "",
  ]);
  return written([head, ...lines]);
}
