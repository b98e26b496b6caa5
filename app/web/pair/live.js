/** Live camera: the newest picture is sent as soon as the server has replied. */

import { askOfImage, Refusal, refused } from "../shared/api.js";
import { called, READINGS, unlike } from "./verdict.js";
import { camera } from "./webcam.js";

const SIDE = 256; // pixels of the longer side sent; encoders use 224
const AT_ONCE = 2; // pictures on the way: one is read while the next one travels
const WINDOW = 1500; // milliseconds, window of the frame rate

/** A button that starts and stops the camera. A click while the camera opens cancels it. */
export class LiveSwitch {
  constructor(button, { place, tell, question, onAnswer, onProblem }) {
    this.button = button;
    this.place = place;
    this.tell = tell;
    this.question = question;
    this.onAnswer = onAnswer;
    this.onProblem = onProblem;
    this.run = null; // a new object for each start: what belongs to an older one is dropped
    button.onclick = () => (this.run ? this.off() : this.start());
  }

  get on() {
    return this.run !== null;
  }

  async start() {
    const mine = (this.run = { stop: () => {} });
    this.onProblem("");
    this.place().innerHTML = "<video autoplay playsinline muted></video>";
    this.button.setAttribute("aria-pressed", "true");
    this.tell("Opening the camera; the first picture also loads the encoder…");
    try {
      const stream = await camera();
      if (this.run !== mine) return release(stream);
      mine.stop = () => release(stream);
      await this.read(mine, stream);
    } catch (error) {
      if (this.run !== mine) return; // cancelled: ignore the consequences
      this.off();
      refused(error, this.onProblem);
    }
  }

  off() {
    this.run?.stop();
    this.run = null;
    this.button.setAttribute("aria-pressed", "false");
    this.onAnswer(null);
  }

  /** Send pictures until the run is over. */
  async read(mine, stream) {
    const video = this.place().querySelector("video");
    video.srcObject = stream;
    await video.play();
    const pictures = { sent: 0, shown: 0, times: [], canvas: document.createElement("canvas") };
    await Promise.all(Array.from({ length: AT_ONCE }, () => this.loop(mine, video, pictures)));
  }

  async loop(mine, video, pictures) {
    while (this.run === mine) {
      const number = ++pictures.sent;
      const began = performance.now();
      const blob = await picture(video, pictures.canvas);
      if (!blob) throw new Refusal("The camera returned no picture.");
      const answer = await askOfImage("live", blob, await this.question(number <= AT_ONCE));
      if (this.run !== mine || number < pictures.shown) continue;
      pictures.shown = number;
      const now = performance.now();
      const fps = rate(pictures.times, now);
      this.tell(toldOf(answer, fps, now - began));
      this.onAnswer({ ...answer, fps });
    }
  }
}

const release = (stream) => stream.getTracks().forEach((track) => track.stop());

function picture(video, canvas) {
  const scale = SIDE / Math.max(video.videoWidth, video.videoHeight, 1);
  canvas.width = Math.max(1, Math.round(video.videoWidth * scale));
  canvas.height = Math.max(1, Math.round(video.videoHeight * scale));
  canvas.getContext("2d").drawImage(video, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/jpeg", 0.92));
}

/** Pictures a second over the last moments; adds `now` to `times`. */
function rate(times, now) {
  times.push(now);
  while (times[0] < now - WINDOW) times.shift();
  return times.length > 2 ? (1000 * (times.length - 1)) / (now - times[0]) : NaN;
}

const toldOf = ({ ms }, fps, trip) =>
  `${Number.isFinite(fps) ? fps.toFixed(0) : "…"} pictures/s; ${Math.round(trip)} ms from camera to prediction (encoder ${ms.encoder} ms, head ${ms.head} ms). None is kept.`;

/** The prediction of the newest picture. */
export function liveHtml({ classes, readings, images }) {
  const given = ["vis", "tac"].filter((name) => readings[name]);
  const parts = READINGS.filter(([reading]) => readings[reading]).map(([reading, title, sign]) => {
    const strange = unlike(reading, given, images);
    return `<article class="reading" data-reading="${reading}"><h3><span class="sign ${sign}"></span>${title}</h3>${called(classes, readings[reading], strange, { images })}</article>`;
  });
  return `<p><b class="tag">live</b></p><div class="readings">${parts.join("")}</div><p class="hint">Everything below belongs to the pair chosen before.</p>`;
}
