/** My sensor: a profile of unlabelled pictures; predictions, familiarity and the map then follow it. */

import { ask, attempt, get, made, refused, visit } from "../shared/api.js";
import { loaded } from "../shared/facts.js";
import { OTHER } from "../shared/images.js";
import { keep, kept } from "../shared/memory.js";
import { save } from "../shared/save.js";
import { base64, bytesOf, escaped, row, table } from "../shared/text.js";
import { onClick, View } from "../shared/view.js";
import { chosenFiles, upload } from "./own-pictures.js";
import { isPicture, named } from "./pairing.js";
import { brief, readingsOf, TERMS } from "./verdict.js";

const KEPT = "omnivat-sensor"; // of this visit: survives a reload, not the browser's end
const AT_ONCE = 50; // pictures of one request
const FEW = 5;
const LOOKED_AT = 3; // pictures whose kind is checked
const plural = (n, [one, many]) => `${n.toLocaleString("en-US")} ${n === 1 ? one : many}`;

/** What a profile was made of, in words. */
export const madeOf = (counts) =>
  Object.entries(counts)
    .map(([name, n]) => plural(n, [TERMS[name].one, TERMS[name].many]))
    .join(" and ");

/** Pictures by modality; those whose names do not tell are `rest`. */
export function sorted(files, rest) {
  const found = { vis: [], tac: [] };
  for (const { path, file } of files) if (isPicture(path)) found[named(path).modality || rest].push(file);
  return found;
}

export class Sensor extends View {
  /** on: again() predicts anew; pair() is the open one. */
  constructor(box, on) {
    super(box);
    this.on = on;
    /** @type {any} */
    this.counts = null;
    this.stopped = new AbortController();
    this.note = "";
    this.doubt = []; // pictures of which the visitor is asked
    visit.renew = () => this.restore();
    onClick(box, {
      ".stop": () => this.stopped.abort(),
      "[data-kind]": ({ dataset }) => this.take(this.doubt, dataset.kind),
      ".off": () => this.use("", null),
      ".save": () => attempt(async () => save("my-sensor.safetensors", await this.bytes()), this.say),
    });
    box.onchange = ({ target }) => {
      const files = chosenFiles(target.files ?? []);
      target.value = target.matches("select") ? target.value : "";
      if (!files.length) return;
      if (target.matches(".load")) this.load(files[0].file);
      else this.take(files);
    };
    this.show();
    this.restore();
  }

  say = (note) => {
    this.note = note;
    this.show();
  };

  show() {
    const { counts, box } = this;
    const rest = box.querySelector("select")?.value ?? "tac";
    const option = (name) => `<option value="${name}"${rest === name ? " selected" : ""}>${TERMS[name].many}</option>`;
    box.innerHTML = `<h3>My sensor</h3><p class="hint">${counts ? `In use: profile of ${madeOf(counts)}. Check it with labelled pairs.` : "5 to 50 pictures, no labels."}</p>
      <div class="row"><label class="choose">Pictures<input type="file" multiple></label><label class="choose">Folder<input type="file" webkitdirectory multiple></label>${counts ? '<button type="button" class="save">Save</button><button type="button" class="off">Stop using it</button>' : '<label class="choose">Load<input type="file" class="load" accept=".safetensors"></label>'}</div>
      <details><summary>Names</summary><label>Pictures not named vis or tac are <select>${option("tac")}${option("vis")}</select></label></details>
      <p class="hint" role="status">${escaped(this.note)}</p><div class="compared"></div>`;
    this.compare();
  }

  /** The open pair as it comes, and with the profile. */
  async compare() {
    const pair = this.on.pair();
    const place = this.$(".compared");
    if (!this.counts || !place || ![pair.vis, pair.tac].some((ref) => ref?.startsWith("image:"))) return;
    await attempt(
      async () => {
        // the panel of the prediction has the reason
        const [before, after] = await Promise.all(
          ["", visit.profile].map((profile) => ask("many", { pairs: [pair], profile })),
        );
        place.innerHTML = sideBySide(before.classes, before.pairs[0], after.pairs[0]);
      },
      () => {},
    );
  }

  /** Make a profile of pictures that were sent before: references of photos and touches. */
  make(photos, touches) {
    return attempt(async () => {
      const { profile, counts } = await ask("profile", { photos, touches, profile: "" });
      this.note = "";
      this.use(profile, counts);
    }, this.say);
  }

  /** files: [{path, file}]. The profile in use stays until the new one is complete. */
  async take(files, sure = "") {
    const mine = (this.stopped = new AbortController());
    const rest = sure || this.$("select").value;
    if (!sure && (await this.doubted(files, rest, mine.signal))) return;
    const queue = Object.entries(sorted(files, rest)).flatMap(([name, some]) => some.map((file) => [name, file]));
    const broken = [];
    /** @type {any} */
    let made = null;
    let batch = { vis: [], tac: [] };
    const flush = async () => {
      if (!batch.vis.length && !batch.tac.length) return;
      made = await ask("profile", { photos: batch.vis, touches: batch.tac, profile: made?.profile ?? "" }, mine.signal);
      batch = { vis: [], tac: [] };
    };
    try {
      for (const [i, [name, file]] of queue.entries()) {
        this.$("[role=status]").innerHTML =
          `Reading picture ${i + 1} of ${queue.length}… <button type="button" class="stop">Cancel</button>`;
        try {
          batch[name].push(await upload(file, mine.signal));
        } catch (error) {
          refused(error, (sentence) => broken.push(sentence));
          mine.signal.throwIfAborted();
        }
        if (batch.vis.length + batch.tac.length === AT_ONCE) await flush();
      }
      await flush();
      const failed = broken.length
        ? ` ${plural(broken.length, ["picture was", "pictures were"])} left out: ${broken[0]}`
        : "";
      if (!made) return this.say(broken[0] ?? "No picture was among these files. Give photos, tactile images or both.");
      const few = Math.min(...Object.values(made.counts)) < FEW ? ` Fewer than ${FEW} of a kind change little.` : "";
      this.note = `${few}${failed}`.trim();
      this.use(made.profile, made.counts);
    } catch (error) {
      if (mine.signal.aborted) return this.say("Cancelled; nothing was changed.");
      refused(error, this.say);
    }
  }

  /** Pictures whose names do not tell, and that look like the other kind: ask which they are. True if asked. */
  async doubted(files, rest, signal) {
    const some = files.filter(({ path }) => isPicture(path) && !named(path).modality).slice(0, LOOKED_AT);
    let strange = 0;
    await attempt(
      async () => {
        for (const { file } of some) {
          const ref = await upload(file, signal);
          const { images } = await ask("familiar", { [rest]: ref, profile: "" }, signal);
          strange += images[rest]?.strays ? 1 : 0;
        }
      },
      () => {}, // a broken picture is named when all are read
    );
    if (2 * strange <= some.length) return false;
    this.doubt = files;
    const [own, other] = [rest, OTHER[rest]].map((name) => TERMS[name].many);
    this.say("");
    this.$("[role=status]").innerHTML =
      `${strange} of ${some.length} look more like ${other} than like ${own}. They are <button type="button" data-kind="${OTHER[rest]}">${other}</button> <button type="button" data-kind="${rest}">${own}</button>`;
    return true;
  }

  load(file) {
    return attempt(async () => {
      const { profile, counts } = await (await get("sensor", { method: "POST", body: file })).json();
      this.note = "";
      this.use(profile, counts);
    }, this.say);
  }

  /** The profile's file. */
  bytes = () => made("save/sensor", { profile: visit.profile });

  use(profile, counts) {
    visit.profile = profile;
    this.counts = counts;
    if (!profile) this.note = "";
    this.show();
    this.on.again();
    const file = async () => base64(new Uint8Array(await (await this.bytes()).arrayBuffer()));
    return attempt(async () => keep(KEPT, profile ? await file() : null, true), this.say);
  }

  /** Send the visit's profile again: after a reload, or to a server that has lost it. True if it is back. */
  async restore() {
    const text = kept(KEPT, true);
    if (text) {
      visit.profile = "";
      await this.load(new Blob([bytesOf(text)]));
    } else {
      const { sensor } = await loaded().catch(() => ({ sensor: null })); // the page itself reports a lost set
      if (sensor?.profile) await this.use(sensor.profile, sensor.counts); // of --profile
    }
    return Boolean(visit.profile);
  }
}

/** Each reading of a pair before and after; guesses have no figure. */
function sideBySide(classes, before, after) {
  const [now, then] = [before, after].map((one) => readingsOf({ classes, ...one }));
  const rows = now.flatMap((one, i) => (one.label ? [row(one.title, [brief(one), brief(then[i])])] : []));
  return table("This pair with the profile", ["This pair", "as it comes", "with the profile"], rows);
}
