/** Live: photo and touch together; the newest frames are sent as soon as the server has replied. */

import { askOfImage, attempt, refused, visit } from "../shared/api.js";
import { csv } from "../shared/csv.js";
import { IMAGES, imagesOf } from "../shared/images.js";
import { save } from "../shared/save.js";
import { each } from "../shared/text.js";
import { onClick, press, View } from "../shared/view.js";
import { Feed, FRAMES, feedHtml } from "./feed.js";
import { camera, upload } from "./own-pictures.js";
import { called, READINGS, unlike } from "./verdict.js";
import { zipped } from "./zip.js";

const AT_ONCE = 2; // requests on the way: one is read while the next one travels
const WINDOW = 1500; // milliseconds, window of the frame rate
const PRESSES = 10; // frames of a calibration
const MOST = 500; // pairs of a recording
const APART = 300; // milliseconds between two recorded pairs, and between frames of a calibration

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

export class Live extends View {
  /** on: answer(found or null), problem(sentence), taught(fresh) -> name, calibrate(files), label(pair, label). */
  constructor(box, on) {
    super(box);
    this.on = on;
    this.run = null; // a new object for each start: what belongs to an older one is dropped
    this.recording = null;
    this.guiding = false; // a rest picture or a calibration has the status line
    this.$(".feeds").innerHTML = each(IMAGES, feedHtml);
    this.feeds = [...box.querySelectorAll(".feed")].map((one) => new Feed(one, (sentence) => this.tell(sentence)));
    onClick(box, {
      ".start": () => (this.run ? this.off() : this.start()),
      ".rest": () => this.guide(() => this.takeRest()),
      ".calibrate": () => this.guide(() => this.calibrate()),
      ".keep": () => this.guide(() => this.label()),
      ".record": () => this.record(),
    });
  }

  tell(text) {
    this.$(".rate").textContent = text;
  }

  /** Tell how Live goes, unless the line is needed for what to do. */
  report(text) {
    if (!this.guiding) this.tell(text);
  }

  /** Run `work`, which tells what to do, with the status line and without a second one beside it. */
  async guide(work) {
    if (this.guiding) return;
    this.guiding = true;
    try {
      await work();
    } finally {
      this.guiding = false;
    }
  }

  press(on) {
    press(this.$(".start"), on);
    this.$(".start").textContent = on ? "Stop" : "Start";
    const desk = this.box.closest(".desk");
    desk.classList.toggle("live", on); // cameras and prediction side by side
    if (on) desk.scrollIntoView();
    for (const feed of this.feeds) feed.active = on;
    for (const name of ["rest", "calibrate", "keep", "record"]) this.$(`.${name}`).disabled = !on;
  }

  async start() {
    const mine = (this.run = { shown: 0, sent: 0, times: [] });
    this.on.problem("");
    this.press(true);
    this.tell("Opening the sources; the first picture also loads the encoder…");
    try {
      if (this.feeds.some((feed) => feed.select("device").value !== "file")) await this.offer(mine);
      else await Promise.all(this.feeds.map((feed) => feed.open()));
      if (this.run !== mine) return this.close();
      if (!this.feeds.some((feed) => feed.on)) {
        this.off();
        return this.tell("No source is chosen: choose a camera or a video file for the photo, the touch or both.");
      }
      await Promise.all(Array.from({ length: AT_ONCE }, () => this.loop(mine)));
    } catch (error) {
      if (this.run !== mine) return; // cancelled: ignore the consequences
      this.off();
      refused(error, this.on.problem);
    }
  }

  /** Names of cameras are told only once one was allowed. */
  async offer(mine) {
    if (this.feeds.every((feed) => ["file", ""].includes(feed.select("device").value) && feed.clip.files.length))
      return;
    const first = await camera();
    const devices = (await navigator.mediaDevices.enumerateDevices()).filter(({ kind }) => kind === "videoinput");
    first.getTracks().forEach((track) => track.stop());
    const taken = new Set();
    for (const feed of this.feeds) {
      if (this.run !== mine) return;
      if (feed.clip.files.length && feed.select("device").value === "file") await feed.open();
      else await feed.offer(devices, taken);
    }
  }

  close() {
    for (const feed of this.feeds) feed.close();
  }

  off() {
    if (this.recording) this.record();
    this.run = null;
    this.press(false);
    this.close();
    this.on.answer(null);
  }

  /** Send the newest frames until the run is over. */
  async loop(mine) {
    while (this.run === mine) {
      const number = ++mine.sent;
      const began = performance.now();
      const there = this.feeds.filter((feed) => feed.on);
      if (!there.length) {
        this.off();
        return this.tell("Live has stopped: no source is left.");
      }
      const contact = Object.fromEntries(there.map((feed) => [feed.modality, feed.draw()]));
      if (contact.tac === false) {
        this.on.answer({ idle: true });
        this.report("No contact, so no class.");
        await pause(60);
        continue;
      }
      const blobs = await Promise.all(there.map((feed) => feed.blob()));
      const question = {
        modality: there.length > 1 ? "both" : there[0].modality,
        split: there.length > 1 ? blobs[0].size : 0,
        taught: await this.on.taught(number <= AT_ONCE),
        head: visit.head,
      };
      const answer = await askOfImage("live", new Blob(blobs), question);
      if (this.run !== mine || number < mine.shown) continue;
      mine.shown = number;
      this.keepPair(there, blobs);
      const now = performance.now();
      this.report(toldOf(answer, rate(mine.times, now), now - began, this.recording?.pairs.length));
      this.on.answer({ ...answer, yours: Boolean(question.taught) });
    }
  }

  async takeRest() {
    const [touch] = this.feeds.filter(({ modality }) => modality === "tac");
    if (touch.on) await touch.takeRest((n) => this.tell(`Do not touch the sensor: ${n} of ${FRAMES}.`));
    else touch.say("A rest picture is of the touch: choose its source first.");
  }

  /** Frames of different presses become the profile of My sensor; frames without contact are left out. */
  async calibrate() {
    const files = [];
    for (let taken = 0; taken < PRESSES && this.run; await pause(APART)) {
      this.tell(`Press differently each time: ${taken + 1} of ${PRESSES}.`);
      const there = this.feeds.filter(({ on }) => on);
      if (there.map((feed) => feed.draw()).includes(false)) continue;
      const drawn = there.map((feed) => ({ name: `${taken}_${feed.modality}.png`, blob: feed.blob("image/png") }));
      for (const { name, blob } of drawn) files.push({ path: name, file: new File([await blob], name) });
      taken++;
    }
    if (this.run) this.on.calibrate(files);
  }

  /** The newest frames join the visitor's labelled pairs. */
  async label() {
    const label = this.$(".label").value.trim();
    const there = this.feeds.filter(({ on }) => on);
    if (!label) return this.tell("Type what it is as the label first.");
    if (there.map((feed) => feed.draw()).includes(false)) return this.tell("No contact, so no pair. Press the sensor.");
    await attempt(async () => {
      const pair = {};
      const drawn = there.map((feed) => [feed.modality, feed.blob("image/png")]);
      for (const [modality, blob] of drawn)
        pair[modality] = await upload(new File([await blob], `live_${modality}.png`));
      await this.on.label(pair, label);
      this.tell(`Added as ${label}.`);
    }, this.on.problem);
  }

  keepPair(there, blobs) {
    const now = Date.now();
    const { recording } = this;
    if (!recording || now - recording.last < APART || recording.pairs.length >= MOST) return;
    recording.last = now;
    const label = this.$(".label").value.trim() || "unlabelled";
    recording.pairs.push({
      label,
      time: new Date(now).toISOString(),
      pictures: there.map(({ modality }, i) => [modality, blobs[i]]),
    });
  }

  /** Start a recording, or end it and save its folder. */
  async record() {
    const done = this.recording;
    this.recording = done ? null : { pairs: [], last: 0 };
    press(this.$(".record"), !done);
    if (done?.pairs.length)
      save("recording.zip", new Blob(zipped(await recorded(done.pairs)), { type: "application/zip" }));
  }
}

/** Files of a recording: pictures in folders that `omnivat embed` reads, and a table. */
export async function recorded(pairs) {
  const files = [];
  const lines = [["vis", "tac", "domain", "material", "time"]];
  for (const [i, { label, time, pictures }] of pairs.entries()) {
    const paths = { vis: "", tac: "" };
    for (const [modality, blob] of pictures) {
      paths[modality] = `My sensor/${label.replaceAll(/[\\/:]/g, "_")}/${i}_${modality}.jpg`;
      files.push([`recording/${paths[modality]}`, new Uint8Array(await blob.arrayBuffer())]);
    }
    lines.push([paths.vis, paths.tac, "My sensor", label, time]);
  }
  return [...files, ["recording/pairs.csv", new TextEncoder().encode(csv(lines))]];
}

/** Pictures a second over the last moments; adds `now` to `times`. */
function rate(times, now) {
  times.push(now);
  while (times[0] < now - WINDOW) times.shift();
  return times.length > 2 ? (1000 * (times.length - 1)) / (now - times[0]) : NaN;
}

const toldOf = ({ ms }, fps, trip, kept) =>
  `${Number.isFinite(fps) ? fps.toFixed(0) : "…"} predictions/s; ${Math.round(trip)} ms from camera to prediction (encoder ${ms.encoder} ms, head ${ms.head} ms). ${kept === undefined ? "No picture is kept." : `${kept} pairs recorded.`}`;

/** The prediction of the newest frames. */
export function liveHtml({ classes, readings, images, yours, idle }) {
  if (idle) return '<p><b class="tag">live</b></p><p class="hint">No contact: press the sensor on something.</p>';
  const given = imagesOf(readings);
  const parts = READINGS.filter(([reading]) => readings[reading]).map(([reading, title, sign]) => {
    const strange = unlike(reading, given, images);
    return `<article class="reading" data-reading="${sign}"><h3><span class="sign ${sign}"></span>${title}</h3>${called(classes, readings[reading], strange, { images, yours })}</article>`;
  });
  return `<p><b class="tag">live</b></p><div class="readings">${parts.join("")}</div><p class="hint">Everything below belongs to the pair chosen before.</p>`;
}
