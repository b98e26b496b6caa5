/** Many pairs at once: a table of predictions with guess marks, and a CSV. */

import { ask, attempt, refused } from "../shared/api.js";
import { csv as written } from "../shared/csv.js";
import { IMAGES } from "../shared/images.js";
import { save } from "../shared/save.js";
import { each, escaped, row, table } from "../shared/text.js";
import { onClick, View } from "../shared/view.js";
import { upload } from "./own-pictures.js";
import { paired } from "./pairing.js";
import { tally } from "./tally.js";
import { brief, READINGS, readingsOf, said, TERMS } from "./verdict.js";

const AT_ONCE = 12; // pairs of one request
const plural = (n, what) => `${n.toLocaleString("en-US")} ${what}${n === 1 ? "" : "s"}`;

export class Many extends View {
  /** on: open(pair), labels(pairs) to count, teach(), profile(photos, touches), classes() of the head, lessons(), changed(first pair). */
  constructor(box, on) {
    super(box);
    this.on = on;
    this.stopped = new AbortController();
    this.rows = [];
    /** @type {any[]} */
    this.unnamed = []; // files whose names do not tell photo from touch
    box.onchange = ({ target }) => target.dataset.label && this.label(+target.dataset.label, target.value.trim());
    onClick(box, {
      "[data-row]": ({ dataset }) => on.open(this.rows[+dataset.row]),
      ".stop": () => this.stopped.abort(),
      ".csv": () => save("pairs.csv", csv(this.rows)),
      ".teach": () => {
        this.count();
        on.teach();
      },
      ".as-profile": () => on.profile(...IMAGES.map((name) => this.rows.flatMap((one) => one[name] || []))),
      "[data-kind]": ({ dataset }) => this.take(this.unnamed, dataset.kind),
      ".close": () => this.close(),
    });
  }

  /** A label typed into the table is counted at once. */
  label(number, text) {
    this.rows[number].label = text;
    this.count();
  }

  count() {
    const labelled = this.rows.filter(({ label, said: answer }) => label && answer);
    if (labelled.length) this.on.labels(labelled);
  }

  close() {
    this.stopped.abort();
    this.rows = [];
    this.box.hidden = true;
  }

  /** files: [{path, file}]; rest: what pictures are whose names do not tell. */
  async take(files, rest = "") {
    this.close();
    const mine = (this.stopped = new AbortController());
    const table = files.find(({ path }) => /\.csv$/i.test(path));
    const { pairs, alone, problem } = paired(
      files,
      table ? await table.file.text() : "",
      await this.on.classes(),
      rest,
    );
    this.box.hidden = false;
    const left = alone.length ? ` ${plural(alone.length, "picture")} left out: no partner by name.` : "";
    if (!pairs.length && alone.length && !table && !rest) {
      this.unnamed = files;
      this.box.innerHTML = `<div class="stand"><p role="status">${plural(alone.length, "picture")} without vis or tac in the name. They are</p>${each(IMAGES, (name) => `<button type="button" data-kind="${name}">${TERMS[name].many}</button>`)}<button type="button" class="close">Close</button></div>`;
      return;
    }
    if (!pairs.length) {
      this.show(
        problem ||
          (table
            ? "The CSV names none of these pictures. Drop it together with them; it needs the columns vis and tac."
            : `No pair was recognised among ${plural(files.length, "file")}. Name them x_vis and x_tac, or add a CSV with the columns vis and tac.`),
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
      this.on.changed(this.rows.find(({ readings: read }) => read));
      this.box.scrollIntoView({ block: "nearest" }); // on a phone it lies below the slots
    } catch (error) {
      if (mine.signal.aborted && this.stopped === mine)
        this.show(` Cancelled after ${this.rows.length} of ${plural(pairs.length, "pair")}.${left}`);
      refused(error, this.show);
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
    if (pair.vis && pair.vis === pair.tac) pair.problem = "Photo and touch are the same picture.";
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
    await attempt(async () => {
      for (let at = 0; at < there.length; at += AT_ONCE)
        await this.predict(there.slice(at, at + AT_ONCE), this.stopped.signal);
      this.show("");
    }, this.show);
  }

  progress(done, total, seconds) {
    const left = done > 1 ? ` About ${Math.ceil((seconds * (total - done + 1)) / (done - 1))} s left.` : "";
    this.box.innerHTML = `<div class="stand"><p>Reading pair ${done} of ${total}…${left}</p><div class="bar-of-epochs"><i style="width:${(100 * done) / total}%"></i></div><button type="button" class="stop">Cancel</button></div>`;
  }

  show = (note) => {
    this.box.innerHTML = this.rows.length
      ? tableHtml(this.rows, note, Boolean(this.on.lessons().lessons))
      : `<div class="stand"><p role="status">${escaped(note)}</p><button type="button" class="close">Close</button></div>`;
  };
}

function tableHtml(rows, note, taught) {
  const read = rows.filter((one) => one.readings).map((one) => ({ ...one, said: readingsOf(one) }));
  const labelled = rows.filter(({ label, readings }) => label && readings);
  const guesses = read.filter(({ said }) => said[0].guess ?? said.some(({ guess }) => guess)).length;
  const right = tally(labelled);
  const scores = READINGS.filter(([reading]) => right[reading]).map(
    ([reading, title]) => `${title.toLowerCase()} ${right[reading].right} of ${right[reading].of}`,
  );
  const names = [...new Set(rows.flatMap(({ classes = [], label }) => [...classes, label]))].filter(Boolean);
  const lines = rows.map((one, i) => {
    if (!one.readings) return row(escaped(one.name), [`<td colspan="4" class="wrong">${escaped(one.problem)}</td>`]);
    const cells = readingsOf(one).map((reading) => {
      const mark = one.label && reading.label && (one.label === reading.label ? "right" : "wrong");
      return `<td class="${mark || ""}">${brief(reading)}</td>`;
    });
    const name = `<button type="button" class="link" data-row="${i}">${escaped(one.name)}</button>`;
    const label = `<input type="text" list="ov-classes" maxlength="40" size="9" data-label="${i}" aria-label="Label of ${escaped(one.name)}" value="${escaped(one.label)}">`;
    const lesson = taught && one.label ? "<small>taught with it</small>" : "";
    return String(row(`${name} ${lesson}`, [label, ...cells])).replace("<tr", `<tr data-pair="${i}"`);
  });
  return `<header><h3>${plural(rows.length, "pair")}: ${plural(guesses, "guess").replace("guesss", "guesses")}</h3><span class="row"><button type="button" class="as-profile" title="Their mean and spread, without labels">Profile of these</button><button type="button" class="main teach">Teach</button><button type="button" class="csv">Save as CSV</button><button type="button" class="close">Close</button></span></header>
    <p class="hint" role="status">${taught ? "By the head taught on your labelled pairs. " : scores.length ? `Right: ${scores.join(", ")}. ` : ""}“?” marks a guess: a picture unlike ${taught ? "those that you labelled" : "anything the head has seen"}. Type a label; a name opens its pair.${escaped(note)}</p>
    <datalist id="ov-classes">${each(names, (name) => `<option value="${escaped(name)}">`)}</datalist>
    ${table("Your pairs and their predictions", ["Pair", "Label", ...READINGS.map(([, title]) => title)], lines)}`;
}

/** One line for each pair: label, and class, probability and guess of each reading. */
export function csv(rows) {
  const names = READINGS.flatMap(([reading]) => [reading, `${reading}_probability`, `${reading}_guess`]);
  const lines = rows.map((one) => {
    const cells = readingsOf({ readings: {}, ...one }).map(({ label = "", share, guess = "" }) => [
      label,
      share?.toFixed(4) ?? "",
      guess,
    ]);
    return [one.name, one.label, ...cells.flat(), one.problem ?? ""];
  });
  return written([["pair", "label", ...names, "problem"], ...lines]);
}
