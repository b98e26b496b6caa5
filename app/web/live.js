/** A camera answered live: the newest picture goes to the server as soon as it has answered. */

import { askOfImage, Refusal, refused } from "./api.js";
import { camera } from "./webcam.js";

const SIDE = 256; // pixels of the longer side that is sent; encoders take 224
const AT_ONCE = 2; // pictures on the way: one is answered while the next one travels
const WINDOW = 1500; // milliseconds that the frame rate is counted over

/**
 * Start; returns what stops it. `ask()` gives {modality, other, order} for each picture, and
 * `onAnswer` gets the server's answer with `fps`, `trip` (ms) and the picture's number.
 */
export async function goLive(video, { ask, onAnswer, onProblem }) {
  const stream = await camera();
  video.srcObject = stream;
  await video.play();
  const canvas = document.createElement("canvas");
  let alive = true;
  let sent = 0;
  let shown = 0;
  const times = [];

  const stop = () => {
    alive = false;
    stream.getTracks().forEach((track) => track.stop());
  };

  function picture() {
    const scale = SIDE / Math.max(video.videoWidth, video.videoHeight, 1);
    canvas.width = Math.max(1, Math.round(video.videoWidth * scale));
    canvas.height = Math.max(1, Math.round(video.videoHeight * scale));
    canvas.getContext("2d").drawImage(video, 0, 0, canvas.width, canvas.height);
    return new Promise((resolve) => canvas.toBlob(resolve, "image/jpeg", 0.92));
  }

  async function run() {
    while (alive) {
      const number = ++sent;
      const began = performance.now();
      const blob = await picture();
      if (!blob) throw new Refusal("The camera gave no picture.");
      const answer = await askOfImage("live", blob, ask());
      if (!alive || number < shown) continue;
      shown = number;
      const now = performance.now();
      times.push(now);
      while (times[0] < now - WINDOW) times.shift();
      const fps = times.length > 2 ? (1000 * (times.length - 1)) / (now - times[0]) : NaN;
      onAnswer({ ...answer, fps, trip: now - began });
    }
  }
  for (let i = 0; i < AT_ONCE; i++) {
    run().catch((error) => {
      if (!alive) return;
      stop();
      refused(error, onProblem);
    });
  }
  return stop;
}
