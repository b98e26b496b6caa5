/** The work that Try a pair needs: requests to the server, files in and out. Its end is an event; a Refusal
 * becomes a sentence in the part that NOTES names. */

import { ask, attempt, bytesOf, get, isOwnPicture, made, Refusal, unread, visit } from "../shared/api.js";
import { loaded } from "../shared/facts.js";
import { headLabel } from "../shared/headsets.js";
import { keep, kept } from "../shared/memory.js";
import { mean } from "../shared/numbers.js";
import { awaited } from "../shared/ready.js";
import { save } from "../shared/save.js";
import { OUTPUT } from "../shared/stages.js";
import { change, openChapter } from "../shared/store.js";
import { openTab } from "../shared/tabs.js";
import { base64, bytesOf as decoded, joined } from "../shared/text.js";
import { guide, live, saveRecording } from "./live.js";
import { csv } from "./many.js";
import { camera, describe, held, snapshot } from "./own-pictures.js";
import { isPicture, LONGEST, named, paired, sorted } from "./pairing.js";
import { batches, imagesOf, LARGEST, plural } from "./parts.js";
import { credit, short } from "./real.js";
import { counted, predicted, quietly } from "./replies.js";
import { isOwn, lessonsFor, lessonsOf, READING } from "./state.js";
import { contentOf, saveZip } from "./zip.js";

const ROWS_AT_ONCE = 4; // pairs that are read between two looks at how many are left
const PICTURES_AT_ONCE = 10; // of a profile
const FEW = 5; // pictures of a kind
const LOOKED_AT = 3; // pictures whose kind is checked
const SOON = 200; // milliseconds, before which a prediction waits for what else is shown of its pair
const TOUCHES = 25; // of each folder of a card
const MEND = "omnivat-mend";
const KEPT = "omnivat-sensor"; // of this visit: survives a reload, not the browser's end

/** The profile in a file. @param {Blob} body @returns {Promise<Profile>} */
const profileIn = async (body) => (await get("sensor", { method: "POST", body })).json();
/** The profile of this visit as a file. */
const profileFile = () => made("save/sensor", { profile: visit.profile });

/** A label as the name of a folder. @param {string} label */
const folderOf = (label) => label.replaceAll(/[\\/:]/g, "_");

/** Work that goes on beside newer work of its kind. @type {(keyof PairWork)[]} */
export const TOGETHER = ["upload", "explain", "count"];
/** Where the sentence of a refused work stands, if not above everything; "" is nowhere.
 * @type {Partial<Record<keyof PairWork, keyof PairTab["notes"] | "">>} */
export const NOTES = {
  ...{ curve: "", compare: "" },
  ...{ count: "own", teach: "own", save: "own", savePictures: "own" },
  ...{ read: "many", rows: "many", guide: "live" },
  ...{ profileOf: "sensor", sample: "sensor", load: "sensor", keepProfile: "sensor", saveProfile: "sensor" },
  card: "card",
};

/** @type {{[Name in keyof PairWork]: (desk: Desk, what: PairWork[Name], signal: AbortSignal) => unknown}} */
export const WORK = {
  /** All that the tab shows of the open pair, by one request: its new pictures go with it. */
  async predict({ tab, send, map }, _, signal) {
    const { vis, tac, heads } = tab;
    if (!vis && !tac) return;
    const question = { vis, tac, ...lessonsOf(tab, tab) };
    const reading = (/** @type {string | undefined} */ words) => {
      for (const name of fresh) send("doing", { [name]: words });
    };
    const fresh = imagesOf(question).filter((name) => unread(question[name]));
    reading(READING);
    const wanted = ["familiar", "journey", "moving", ...(heads.length ? ["rivals"] : [])];
    let early = 0;
    // on a busy server the rest follows later
    const begun = (/** @type {Predicted} */ answer) => {
      early = setTimeout(() => {
        reading(undefined);
        map?.(null, "Placing this pair on the map…");
        send("predicted", { answer, question, moving: answer.linear ? null : { answer, question } });
      }, SOON);
    };
    signal.addEventListener("abort", () => clearTimeout(early));
    const found = await ask("pair", { ...question, with: wanted }, signal, [], begun).finally(() => {
      clearTimeout(early);
      reading(undefined);
    });
    const { familiar, journey, moving, rivals, ...answer } = found;
    const there = "problem" in journey ? null : journey;
    map?.(there, "problem" in journey ? journey.problem : "");
    send("predicted", {
      answer,
      question,
      familiar,
      journey: there,
      rivals: rivals ? heads.map((one) => ({ ...rivals[one.name], label: headLabel(one) })) : null,
      moving:
        moving && !("problem" in moving) ? { answer: moving, question: { vis, tac, head: "" } } : { answer, question },
    });
  },
  /** Show the open pair in the chapter of the gaps, by the head of the chapters. */
  everyP() {
    openChapter("gaps", { by: "", stage: OUTPUT });
    openTab("explore");
  },
  /** Open a pair of the set, which Explore then shows too. */
  pin: (_, { pair }) => change({ pin: +pair, vis: `row:${pair}`, tac: `row:${pair}` }),
  /** The open pair without the profile. */
  async compare({ tab: { vis, tac, counts, mend, question }, send }, _, signal) {
    if (!(counts || mend) || ![vis, tac].some(isOwnPicture)) return;
    const plain = { pairs: [{ vis, tac }], lessons: question?.lessons, profile: "", mend: "" };
    const { classes, pairs } = await ask("many", plain, signal);
    if (!pairs[0].problem) send("arrived", { before: { classes, ...pairs[0] } });
  },

  async upload({ send }, { modality, file }) {
    send("noted", { problem: "" });
    send("doing", { [modality]: READING });
    send("uploaded", { modality, ref: await held(file, send) });
  },
  async photograph({ send, box }, { modality }, signal) {
    const stream = await camera();
    send("arrived", { filming: modality });
    const picture = await snapshot(/** @type {Element} */ (box.querySelector(".filming")), stream, signal);
    for (const track of stream.getTracks()) track.stop();
    send("arrived", { filming: "" });
    if (picture) send("upload", { modality, file: new File([picture], "the camera’s image", { type: picture.type }) });
  },
  /** Hide one part of a picture after the other. */
  async explain({ tab, send }, { modality }) {
    const { vis, tac, [modality]: ref } = tab;
    send("doing", { [modality]: "Hiding one part after the other…" });
    const blob = await bytesOf(ref ?? "", modality);
    if (!blob) throw new Refusal("The server keeps no images. Choose this file again.");
    const lessons = lessonsOf(tab, tab);
    const parts = await ask("occlusion", { vis, tac, modality, ...lessons }, undefined, [blob]);
    send("explained", { [modality]: { ...parts, taught: Boolean(lessons.lessons) } });
  },
  /** Read a real pair as if its pictures had been dropped. */
  async fetch({ tab, send }, { key }) {
    const [set, number] = key.split("/").map(Number);
    const from = /** @type {RealSet} */ (tab.real?.sets[set]);
    const { pictures, class: words } = from.pairs[number];
    const wanted = imagesOf(pictures).filter((name) => ["both", name].includes(tab.take));
    if (!wanted.length) throw new Refusal(`${short(from)} has touches alone.`);
    send("doing", { fetch: key });
    /** @type {Pair} */
    const pair = tab.take === "both" ? { vis: null, tac: null } : {};
    for (const name of wanted) {
      const content = await (await get(`real/${pictures[name]}`)).blob();
      const { type } = content;
      pair[name] = await held(new File([content], `${words}, ${short(from)}`, { type }), send, credit(from));
    }
    send("fetched", { key, pair });
  },

  async count({ tab, send }, pair) {
    const names = [pair.vis, pair.tac].flatMap((ref) => (ref ? [tab.sent[ref]?.name ?? describe(tab, ref).text] : []));
    send("counted", await counted({ ...pair, name: [...new Set(names)].join(" + ") }));
  },
  async teach({ tab, send }) {
    send("noted", { own: "Teaching…" });
    send("taught", await ask("teach", { lessons: lessonsFor(tab.pairs) }));
  },
  /** What fewer labels would have taught; a page without a server has no such curve. */
  async curve({ tab, send }, _, signal) {
    send("arrived", { labels: await ask("curve", { lessons: lessonsFor(tab.pairs) }, signal) });
  },
  async save({ tab }, { path, name }) {
    save(name, await made(path, { lessons: lessonsFor(tab.pairs) }));
  },
  /** The pictures still in this browser, in folders for `omnivat embed`. */
  async savePictures({ tab }) {
    /** @type {[string, Uint8Array][]} */
    const files = [];
    for (const [number, pair] of tab.pairs.entries()) {
      for (const modality of imagesOf(pair)) {
        const blob = await bytesOf(pair[modality] ?? "", modality);
        if (!blob) continue;
        const [ending] = /png|webp|tiff|bmp/.exec(blob.type) ?? ["jpg"];
        const name = `my-pairs/My pairs/${folderOf(pair.label)}/${number}_${modality}.${ending}`;
        files.push([name, await contentOf(blob)]);
      }
    }
    if (!files.length) throw new Refusal("This browser no longer has pictures of these pairs.");
    saveZip("my-pictures.zip", files);
  },

  live,
  guide,
  saveRecording,

  read: (...given) => awaited(read(...given)),
  /** Predict the pairs of the table again. */
  async rows({ tab, send }, _, signal) {
    const there = tab.rows.filter(({ said }) => said);
    const answers = await predicted(there, lessonsOf(tab), signal);
    if (answers.length) send("rowsPredicted", answers);
  },
  csv: ({ tab }) => save("pairs.csv", csv(tab.rows)),

  async profileOf({ send }, pictures) {
    send("profiled", await ask("profile", { ...pictures, profile: "" }));
  },
  card: (...given) => awaited(card(...given)),
  sample: (...given) => awaited(sample(...given)),
  async load({ send }, { files }) {
    send("profiled", await profileIn(files[0].file));
  },
  async keepProfile({ tab }) {
    keep(MEND, tab.mend || null, true);
    keep(KEPT, tab.profile ? base64(await contentOf(await profileFile())) : null, true);
  },
  async saveProfile() {
    save("my-sensor.safetensors", await profileFile());
  },
};

/** Send the visit's profile again: after a reload, or to a server that has lost it. True if it is back.
 * @param {Desk} desk */
export async function restore({ send }) {
  const text = kept(KEPT, true);
  const mend = kept(MEND, true);
  if (mend) send("arrived", { mend });
  if (text) send("arrived", { profile: "", counts: null });
  await attempt(
    async () => {
      const { sensor } = text ? { sensor: await profileIn(new Blob([decoded(text)])) } : await loaded();
      if (sensor.profile) send("profiled", /** @type {Profile} */ (sensor)); // without a text: that of --profile
    },
    (/** @type {string} */ sensor) => text && send("noted", { sensor }), // the page itself reports a lost set
  );
  return Boolean(visit.profile);
}

/** A pair of files as a row. @param {FilePair} pair @param {Desk["send"]} send @returns {Promise<Row>} */
async function rowOf(pair, send) {
  /** @type {Row} */
  const row = { ...pair, vis: null, tac: null };
  for (const name of imagesOf(pair)) {
    const ref = await quietly(held(/** @type {File} */ (pair[name]), send));
    Object.assign(row, typeof ref === "string" ? { [name]: ref } : ref);
  }
  if (row.vis && row.vis === row.tac) return { ...row, problem: "Photo and touch are the same picture." };
  const { length } = pair.label;
  if (length <= LONGEST) return row;
  return {
    ...row,
    label: "",
    problem: `The label '${pair.label}' has ${length} letters; at most ${LONGEST} are taken.`,
  };
}

/** Pair files by their names or a CSV, send them and predict them, some at a time.
 * @param {Desk} desk @param {PairWork["read"]} what @param {AbortSignal} signal */
async function read({ tab, send }, { files, kind }, signal) {
  const table = files.find(({ path }) => /\.csv$/i.test(path));
  const { classes } = (await loaded()).head;
  const { pairs, alone, problem } = paired(files, table ? await table.file.text() : "", classes, kind);
  const total = pairs.length;
  if (!total && alone.length && !table && !kind) return send("arrived", { unnamed: { files, count: alone.length } });
  const none = table
    ? "The CSV names none of these pictures. Drop it together with them; it needs the columns vis and tac."
    : `No pair was recognised among ${plural(files.length, "file")}. Name them x_vis and x_tac, or add a CSV with ` +
      "the columns vis and tac.";
  const left = alone.length ? ` ${plural(alone.length, "picture")} left out: no partner by name.` : "";
  send("noted", { many: total ? left : problem || none });
  const began = Date.now();
  for (let done = 0; done < total; ) {
    const rows = [];
    for (const pair of pairs.slice(done, done + ROWS_AT_ONCE)) {
      const wait = done && Math.ceil(((Date.now() - began) * (total - done)) / done / 1000);
      send("doing", { read: { done: ++done, total, wait } });
      rows.push(await rowOf(pair, send));
    }
    const there = rows.filter((row) => !row.problem);
    const answers = await predicted(there, lessonsOf(tab), signal);
    send(
      "touched",
      answers.flatMap(({ tac, problem }) => (problem ? [] : (tac ?? []))),
    );
    send(
      "rowsRead",
      rows.map((row) => answers[there.indexOf(row)] ?? row),
    );
  }
  send("allRead", {});
}

/** The cards of the folders; what the first touch of the new one shows takes an example's place.
 * @param {Desk} desk @param {unknown} _ @param {AbortSignal} signal */
async function card({ tab, send }, _, signal) {
  const { now, before } = tab.folders;
  const touches = [now, before].map((files) =>
    files.flatMap(({ path, file }) => (isPicture(path) && named(path).modality !== "vis" ? file : [])),
  );
  if (!touches[0].length) throw new Refusal("Give touches of your sensor: JPEG, PNG, WebP, BMP or TIFF pictures.");
  const all = touches.flat();
  const size = mean(all.map((file) => file.size));
  const most = Math.min(TOUCHES, Math.floor(LARGEST / size / touches.filter(({ length }) => length).length));
  const some = touches.map((files) =>
    files.length <= most ? files : Array.from({ length: most }, (_, k) => files[Math.floor((k * files.length) / most)]),
  );
  send("doing", { card: `Reading ${plural(some.flat().length, "touch", "touches")}…` });
  const found = await ask("card", { new: some[0].length }, signal, some.flat());
  const tac = tab.on || isOwn(tab) ? null : await held(some[0][0], send);
  send("cardRead", { card: found, tac });
}

/** Make a profile of pictures. The profile in use stays until the new one is complete.
 * @param {Desk} desk @param {PairWork["sample"]} what @param {AbortSignal} signal */
async function sample({ send }, { files, kind }, signal) {
  const rest = kind ?? "tac";
  const untold = files.filter(({ path }) => isPicture(path) && !named(path).modality).slice(0, kind ? 0 : LOOKED_AT);
  let strange = 0; // of a few pictures whose names do not tell, those that look like the other kind
  for (const { file } of untold) {
    const ref = await quietly(held(file, send));
    if (typeof ref !== "string") continue; // a broken picture is named when all are read
    const seen = await quietly(ask("familiar", { [rest]: ref, profile: "" }, signal));
    if ("images" in seen && seen.images[rest]?.strays) strange++;
  }
  if (2 * strange > untold.length) return send("arrived", { doubt: { files, strange, of: untold.length } });
  const queue = sorted(files, rest);
  /** @type {string[]} */
  const broken = [];
  let profile = /** @type {Profile | null} */ (null);
  let done = 0;
  for (const some of batches(queue, PICTURES_AT_ONCE, ([, { size }]) => size)) {
    const refs = { vis: /** @type {Ref[]} */ ([]), tac: /** @type {Ref[]} */ ([]) };
    send("doing", { sample: { done: (done += some.length), total: queue.length } });
    for (const [name, file] of some) {
      const ref = await quietly(held(file, send));
      if (typeof ref === "string") refs[name].push(ref);
      else broken.push(ref.problem);
    }
    if (!(refs.vis.length + refs.tac.length)) continue;
    const pictures = { photos: refs.vis, touches: refs.tac, profile: profile?.profile ?? "", anew: true };
    const made = await quietly(ask("profile", pictures, signal));
    if ("problem" in made) broken.push(...some.map(() => made.problem));
    else {
      broken.push(...(made.broken ?? []));
      profile = made;
      send("touched", refs.tac);
    }
  }
  if (!profile)
    throw new Refusal(broken[0] ?? "No picture was among these files. Give photos, tactile images or both.");
  const few = Math.min(...Object.values(profile.counts)) < FEW && `Fewer than ${FEW} of a kind change little.`;
  const failed = broken.length && `${plural(broken.length, "picture was", "pictures were")} left out: ${broken[0]}`;
  send("profiled", { ...profile, note: joined([few, failed], " ") });
}
