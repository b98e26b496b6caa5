/** One picture source of Live: a camera or a video file, cropped and turned; its rest picture and contact. */

import { Refusal, refused } from "../shared/api.js";
import { keep, keptJson } from "../shared/memory.js";
import { each, escaped } from "../shared/text.js";
import { camera } from "./own-pictures.js";
import { TERMS } from "./verdict.js";

const KEPT = "omnivat-live-";
const SIDE = 256; // pixels of the longer side sent; encoders use 224
export const FRAMES = 10; // of a rest picture
const LATE = 250; // milliseconds to wait for a new frame; some browsers do not announce frames
const GRID = 16; // blocks along a side of the picture, of which contact changes some
const LEAST = 3; // grey levels of a block: smaller changes are never contact
const NOISE = 2; // contact changes a block by more than this many times the most that rest frames do
/** Crops: [label, share kept of width and height for a frame of this aspect]. */
export const CROPS = {
  "": ["whole", () => [1, 1]],
  "4:3": ["4:3 (DIGIT)", (wide, high) => [Math.min(1, (4 * high) / (3 * wide)), Math.min(1, (3 * wide) / (4 * high))]],
  border: ["border 0.15 (GelSight Mini)", () => [0.7, 0.7]],
};

export const feedHtml = (
  name,
) => `<div class="feed" data-modality="${name}"><h4><span class="sign ${name}"></span>${TERMS[name].title}</h4>
  <canvas width="160" height="120" role="img" aria-label="${TERMS[name].title}, as it is sent"></canvas>
  <label>Source <select class="device"><option value="">none</option><option value="file">video file…</option></select></label>
  <label>Crop <select class="crop">${each(Object.entries(CROPS), ([key, [label]]) => `<option value="${key}">${label}</option>`)}</select></label>
  <label>Turn <select class="turn">${each([0, 90, 180, 270], (turn) => `<option value="${turn}">${turn}°</option>`)}</select></label>
  <input type="file" class="clip" hidden accept="video/*" aria-label="Video of the ${TERMS[name].one}">
  <p class="hint state" role="status"></p></div>`;

export class Feed {
  /** tell(sentence) shows why a source could not be opened. */
  constructor(box, tell) {
    this.box = box;
    this.tell = tell;
    this.modality = box.dataset.modality;
    this.video = Object.assign(document.createElement("video"), { muted: true, loop: true, playsInline: true });
    this.canvas = box.querySelector("canvas");
    this.rest = null; // {shape, mean: grey level of each block, limit}
    this.active = false; // a source chosen while Live runs opens at once
    this.stream = null;
    for (const select of box.querySelectorAll("select"))
      select.onchange = () => this.changed(select).catch((error) => refused(error, tell));
    this.clip = box.querySelector(".clip");
    this.clip.onchange = () => this.active && this.open().catch((error) => refused(error, tell));
    this.wanted = keptJson(KEPT + this.modality, {});
    for (const name of ["crop", "turn"]) this.select(name).value = this.wanted[name] ?? this.select(name).value;
  }

  select = (name) => this.box.querySelector(`.${name}`);
  get on() {
    return this.video.videoWidth > 0 && Boolean(this.video.srcObject || this.video.src);
  }

  /** Offer the devices by name; the remembered one is chosen, else the first that `taken` does not have. */
  async offer(devices, taken) {
    const device = this.select("device");
    for (const old of device.querySelectorAll("option.camera")) old.remove();
    device.insertAdjacentHTML(
      "beforeend",
      each(
        devices,
        ({ deviceId, label }) =>
          `<option class="camera" value="${escaped(deviceId)}">${escaped(label || "camera")}</option>`,
      ),
    );
    const known =
      devices.find(({ label }) => label === this.wanted.device) ?? devices.find(({ deviceId }) => !taken.has(deviceId));
    device.value = this.wanted.device === "none" ? "" : (known?.deviceId ?? "");
    taken.add(device.value);
    await this.open();
  }

  async changed(select) {
    if (select.matches(".device") && select.value === "file") this.clip.click();
    else if (select.matches(".device") && this.active) await this.open();
    const device = this.select("device");
    this.wanted = {
      device: device.value === "file" ? "" : device.value ? device.selectedOptions[0].text : "none",
      crop: this.select("crop").value,
      turn: this.select("turn").value,
    };
    keep(KEPT + this.modality, JSON.stringify(this.wanted));
  }

  /** What a rest picture depends on: source, crop, turn and size. */
  get shape() {
    const [clip] = this.clip.files;
    const menus = ["device", "crop", "turn"].map((name) => this.select(name).value);
    return [...menus, clip?.name, this.video.videoWidth, this.video.videoHeight].join();
  }

  /** Tell what became of the rest picture or the source; it stays until something else does. */
  say(sentence) {
    this.box.querySelector(".state").textContent = sentence;
  }

  async open() {
    this.close();
    const { value } = this.select("device");
    if (!value) return;
    const { video } = this;
    if (value === "file") {
      if (!this.clip.files[0]) return;
      video.src = URL.createObjectURL(this.clip.files[0]);
    } else {
      video.srcObject = this.stream = await camera({ deviceId: { exact: value } });
      this.stream.getVideoTracks()[0].onended = () => {
        this.close();
        this.say(`The camera of the ${TERMS[this.modality].one} was disconnected.`);
      };
    }
    try {
      await video.play();
    } catch {
      throw new Refusal(
        `This source of the ${TERMS[this.modality].one} cannot be played here; choose another camera or video.`,
      );
    }
  }

  close() {
    this.stream?.getTracks().forEach((track) => track.stop());
    this.stream = null;
    this.video.srcObject = null;
    this.video.removeAttribute("src");
    this.video.load();
  }

  /** Draw the newest frame, cropped and turned. Returns whether it touches something: null without a rest picture. */
  draw() {
    const { video, canvas } = this;
    if (this.rest && this.rest.shape !== this.shape) {
      this.rest = null;
      this.say(
        `The rest picture of the ${TERMS[this.modality].one} was dropped, because its source, crop, turn or size changed. Take it again.`,
      );
    }
    const [across, down] = CROPS[this.select("crop").value][1](video.videoWidth, video.videoHeight);
    const [wide, high] = [video.videoWidth * across, video.videoHeight * down];
    const turn = +this.select("turn").value;
    const scale = SIDE / Math.max(wide, high);
    const size = [wide, high].map((length) => Math.max(1, Math.round(length * scale)));
    [canvas.width, canvas.height] = turn % 180 ? size.toReversed() : size;
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.translate(canvas.width / 2, canvas.height / 2);
    context.rotate((turn * Math.PI) / 180);
    context.drawImage(
      video,
      (video.videoWidth - wide) / 2,
      (video.videoHeight - high) / 2,
      wide,
      high,
      -size[0] / 2,
      -size[1] / 2,
      ...size,
    );
    return this.rest ? apart(grey(canvas), this.rest.mean) > this.rest.limit : null;
  }

  blob(type = "image/jpeg") {
    return new Promise((resolve) => this.canvas.toBlob(resolve, type, 0.92));
  }

  /** Wait for a new frame, or a moment. */
  fresh() {
    return new Promise((done) => {
      setTimeout(done, LATE);
      this.video.requestVideoFrameCallback?.(done);
    });
  }

  /** Take the rest picture: the mean of some frames, and their noise. told(n) gets the number so far. */
  async takeRest(told) {
    this.rest = null;
    let frames = [];
    let { shape } = this;
    while (frames.length < FRAMES) {
      await this.fresh();
      if (!this.on) return;
      this.draw();
      if (shape !== this.shape) frames = []; // from the start with another source, crop, turn or size
      shape = this.shape;
      frames.push(grey(this.canvas));
      told(frames.length);
    }
    const rest = restOf(frames);
    this.rest = rest && { shape, ...rest };
    this.say(
      rest
        ? `Rest picture: the mean of ${FRAMES} frames.`
        : "No rest picture: the frames differ as by a touch. Take it again without touching the sensor.",
    );
  }
}

const grey = (canvas) => blocksOf(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height));

/** Mean grey level of each of GRID x GRID blocks of a picture. */
export function blocksOf({ data, width, height }) {
  const sums = new Float32Array(GRID * GRID);
  const counts = new Float32Array(GRID * GRID);
  for (let y = 0, i = 0; y < height; y++) {
    const row = GRID * Math.floor((y * GRID) / height);
    for (let x = 0; x < width; x++, i += 4) {
      const block = row + Math.floor((x * GRID) / width);
      sums[block] += (data[i] + data[i + 1] + data[i + 2]) / 3;
      counts[block]++;
    }
  }
  return sums.map((sum, block) => sum / (counts[block] || 1));
}

/**
 * The largest change of a block between two pictures, beyond the median change. A press changes few
 * blocks, so the mean over the picture hides it; other light changes all of them alike.
 */
export function apart(one, other) {
  const changes = one.map((value, i) => value - other[i]);
  const median = changes.toSorted()[changes.length >> 1];
  return changes.reduce((most, change) => Math.max(most, Math.abs(change - median)), 0);
}

/** The rest picture of some frames and the limit beyond which a picture is a contact; null if they differ as by a touch. */
export function restOf(frames) {
  const mean = frames[0].map((_, i) => frames.reduce((sum, one) => sum + one[i], 0) / frames.length);
  const noise = Math.max(...frames.map((one) => apart(one, mean)));
  return noise > LEAST ? null : { mean, limit: Math.max(LEAST, NOISE * noise) };
}
