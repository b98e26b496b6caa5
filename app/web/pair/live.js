/** Live: photo and touch together; the newest frames are sent as soon as the server has replied. */

import { ask, attempt } from "../shared/api.js";
import { FRAMES } from "./feed.js";
import { dataSets } from "./lerobot.js";
import { camera, held } from "./own-pictures.js";
import { button, html, pressed, status } from "./parts.js";
import { counted, taughtBy } from "./replies.js";
import { lessonsOf } from "./state.js";
import { contentOf, saveZip } from "./zip.js";

const AT_ONCE = 2; // requests on the way: one is read while the next one travels
const WINDOW = 1500; // milliseconds, window of the frame rate
const PRESSES = 10; // frames of a calibration
const APART = 300; // milliseconds between two frames of a calibration
const IDLE = 60; // milliseconds between two looks at a sensor without contact
const AT_REST = { idle: true, classes: [], readings: {}, images: {} };

const pause = (/** @type {number} */ ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** What is below the sources. @param {PairTab} tab */
export function controlsHtml({ on, line, recording, notes }) {
  const off = !on && " disabled";
  const guide = (/** @type {string} */ what, /** @type {string} */ words, /** @type {string} */ title) =>
    button("guide", words, html`data-what="${what}" title="${title}"${off}`);
  return html`<div class="row">${button("camerasSwitched", on ? "Stop" : "Start", html`class="main" ${pressed(on)}`)}
    ${guide("rest", "No-contact picture", "Take ten frames of the untouched sensor")}
    ${guide("calibrate", "Calibrate", "Take ten frames of different presses for the card and the profile of My sensor")}
    </div>
    <div class="row"><label>Label <input type="text" class="label" maxlength="40" size="8"></label>
      ${guide("label", "Add to my pairs", "Add the current pictures to your labelled pairs")}
      ${button("recordSwitched", "Record", html`${pressed(recording)}${off}`)}</div>
    ${status(notes.live, "guided")}${status(line, "rate")}`;
}

/** Draw the newest frames. Returns the open sources, and whether no sensor is touched. @param {Desk} desk */
function drawn({ feeds }) {
  const there = feeds.filter(({ on }) => on);
  return { there, idle: there.map((feed) => feed.draw()).includes(false) };
}

/** The newest frames without loss, as files. @param {Desk} desk @param {string | number} name
 * @returns {Promise<[Modality, File][]>} */
const filesOf = ({ feeds }, name) =>
  Promise.all(
    feeds
      .filter(({ on }) => on)
      .map(async (feed) => [feed.modality, new File([await feed.blob("image/png")], `${name}_${feed.modality}.png`)]),
  );

/** The label that the visitor typed. @param {Desk} desk */
const labelIn = ({ box }) => /** @type {Found} */ (box.querySelector(".cameras .label")).value.trim();

/** Send the newest frames of the sources until they are switched off. @param {Desk} desk @param {unknown} _
 * @param {AbortSignal} signal */
export async function live(desk, _, signal) {
  const { send, feeds, box } = desk;
  let why = "";
  box.querySelector(".desk")?.scrollIntoView();
  const close = () => {
    for (const feed of feeds) {
      feed.active = false;
      feed.close();
    }
  };
  for (const feed of feeds) feed.active = true;
  signal.onabort = close;
  const read = async () => {
    await openAll(feeds, signal);
    const run = { shown: 0, sent: 0, times: [] };
    why = feeds.some(({ on }) => on)
      ? (await Promise.all(Array.from({ length: AT_ONCE }, () => loop(desk, run, signal))))[0]
      : "No source is chosen. Choose a camera or a video file for the photo, the touch or both.";
  };
  try {
    await attempt(read, (/** @type {string} */ problem) => send("noted", { problem }));
  } finally {
    if (!signal.aborted || !desk.tab.on) close(); // not the sources of a newer start
    send("camerasOff", why); // which ends this work, so a problem is noted before
  }
}

/** Open the sources. Cameras have names only once one was allowed. @param {Desk["feeds"]} feeds
 * @param {AbortSignal} signal */
async function openAll(feeds, signal) {
  const cameras = feeds.filter(({ menus }) => menus.device.value !== "file");
  if (cameras.length) {
    const first = await camera();
    const devices = (await navigator.mediaDevices.enumerateDevices()).filter(({ kind }) => kind === "videoinput");
    for (const track of first.getTracks()) track.stop();
    const taken = new Set();
    for (const feed of cameras) feed.offer(devices, taken);
  }
  for (const feed of feeds) if (!signal.aborted) await feed.open();
}

/** Send the newest frames, again and again. Returns why it ended. @param {Desk} desk
 * @param {{shown: number, sent: number, times: number[]}} run @param {AbortSignal} signal */
async function loop(desk, run, signal) {
  while (!signal.aborted) {
    const number = ++run.sent;
    const began = performance.now();
    const { there, idle } = drawn(desk);
    if (!there.length) return "Live has stopped, because no source is left.";
    if (idle) {
      desk.send("framed", { frame: AT_REST, line: "No contact, so no prediction." });
      await pause(IDLE);
      continue;
    }
    const sizes = there.map(({ canvas: { width, height } }) => /** @type {const} */ ([width, height]));
    const blobs = await Promise.all(there.map((feed) => feed.blob()));
    const both = there.length > 1;
    const taught = await taughtBy(lessonsOf(desk.tab), number <= AT_ONCE);
    const question = { modality: both ? "both" : there[0].modality, taught, head: desk.tab.head };
    const answer = await ask("live", question, undefined, blobs);
    if (number < run.shown) continue;
    run.shown = number;
    const now = performance.now();
    desk.send("framed", {
      frame: { ...answer, yours: Boolean(taught) },
      line: toldOf(answer, rate(run.times, now), now - began, desk.tab.recording?.length),
      pair: {
        label: labelIn(desk) || "unlabelled",
        time: Date.now(),
        pictures: there.map(({ modality }, i) => /** @type {const} */ ([modality, blobs[i], sizes[i]])),
      },
    });
  }
  return "";
}

/** Each tells what to do in a line that no frame writes; what it returns stays there.
 * @type {Record<string, (desk: Desk, tell: (sentence: string) => void) => Promise<string | void>>} */
const GUIDES = {
  async rest({ feeds }, tell) {
    const touch = /** @type {Desk["feeds"][number]} */ (feeds.find(({ modality }) => modality === "tac"));
    if (touch.on) await touch.takeRest((n) => tell(`Do not touch the sensor: ${n} of ${FRAMES}.`));
    else touch.say("A no-contact picture shows the untouched sensor. Choose the source of the touch first.");
  },
  /** Frames of different presses become the card and the profile of My sensor; frames without contact are left out. */
  async calibrate(desk, tell) {
    /** @type {Chosen[]} */
    const files = [];
    for (let taken = 0; taken < PRESSES && desk.tab.on; await pause(APART)) {
      tell(`Press differently each time: ${taken + 1} of ${PRESSES}.`);
      if (drawn(desk).idle) continue;
      for (const [, file] of await filesOf(desk, taken)) files.push({ path: file.name, file });
      taken++;
    }
    if (!desk.tab.on) return;
    /** @type {HTMLDetailsElement} */ (desk.box.querySelector(".sensor")).open = true;
    desk.send("carded", { files });
    desk.send("sampled", { files, kind: "tac" });
  },
  /** The newest frames join the visitor's labelled pairs. */
  async label(desk) {
    const label = labelIn(desk);
    if (!label) return "Type the true class as the label first.";
    if (drawn(desk).idle) return "There is no contact, so no pair was added. Press the sensor.";
    /** @type {Pair} */
    const pair = {};
    for (const [modality, file] of await filesOf(desk, "live")) pair[modality] = await held(file, desk.send);
    desk.send("counted", await counted({ ...pair, label, name: `live ${new Date().toLocaleTimeString()}` }));
    return `Added as ${label}.`;
  },
};

/** @param {Desk} desk @param {{what: string}} wanted */
export async function guide(desk, { what }) {
  const tell = (live = "") => desk.send("noted", { live });
  tell((await GUIDES[what](desk, tell)) ?? "");
}

/** Save a recording as data sets of LeRobot. @param {Desk} _ @param {Recorded[]} pairs */
export async function saveRecording(_, pairs) {
  saveZip("recording.zip", await dataSets(pairs, contentOf));
}

/** Pictures a second over the last moments; adds `now` to `times`. @param {number[]} times @param {number} now */
function rate(times, now) {
  times.push(now);
  while (times[0] < now - WINDOW) times.shift();
  return times.length > 2 ? ((1000 * (times.length - 1)) / (now - times[0])).toFixed(0) : "…";
}

/** @param {Replies["live"]} answer @param {string} fps @param {number} trip @param {number} [kept] */
const toldOf = ({ ms }, fps, trip, kept) =>
  `${fps} predictions per second; ${Math.round(trip)} ms from camera to prediction (encoder ${ms.encoder} ms, ` +
  `head ${ms.head} ms). ${kept === undefined ? "No picture is kept." : `${kept} pairs recorded.`}`;
