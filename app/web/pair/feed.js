/** One picture source of Live: a camera or a video file, cropped and turned; its no-contact picture and contact. */

import { attempt, Refusal } from "../shared/api.js";
import { drawingOn } from "../shared/canvas.js";
import { keep, keptJson } from "../shared/memory.js";
import { mean as meanOf } from "../shared/numbers.js";
import { View } from "../shared/view.js";
import { camera } from "./own-pictures.js";
import { html, options, put, signed, status, TERMS } from "./parts.js";

const KEPT = "omnivat-live-";
const SIDE = 256; // pixels of the longer side sent; encoders use 224
export const FRAMES = 10; // of a no-contact picture
const LATE = 250; // milliseconds to wait for a new frame; some browsers do not announce frames
const GRID = 16; // blocks along a side of the picture, of which contact changes some
const LEAST = 3; // grey levels of a block: smaller changes are never contact
const NOISE = 2; // contact changes a block by more than this many times the most that frames without contact do
/** Crops: [label, size kept of a frame].
 * @type {Record<string, [string, (wide: number, high: number) => [number, number]]>} */
const CROPS = {
  "": ["whole", (...size) => size],
  "4:3": ["4:3 (DIGIT)", (wide, high) => [Math.min(wide, (4 * high) / 3), Math.min(high, (3 * wide) / 4)]],
  border: ["border 0.15 (GelSight Mini)", (wide, high) => [0.7 * wide, 0.7 * high]],
};
/** The menus of a feed, and their first choices. @type {Record<"device" | "crop" | "turn", [string, string[][]]>} */
const MENUS = {
  device: [
    "Source",
    [
      ["", "none"],
      ["file", "video file…"],
    ],
  ],
  crop: ["Crop", Object.entries(CROPS).map(([key, [label]]) => [key, label])],
  turn: ["Turn", [0, 90, 180, 270].map((turn) => [String(turn), `${turn}°`])],
};

/** @param {Modality} name */
export const feedHtml = (
  name,
) => html`<div class="feed" data-modality="${name}"><h4>${signed(name, TERMS[name].title)}</h4>
  <canvas width="160" height="120" role="img" aria-label="${TERMS[name].title}, as it is sent"></canvas>
  <div class="row">${Object.entries(MENUS).map(
    ([menu, [title, all]]) => html`<label>${title} <select class="${menu}">
    ${options(all)}</select></label>`,
  )}</div>
  <input type="file" class="clip" hidden accept="video/*" aria-label="Video of the ${TERMS[name].one}">
  ${status("", "state")}</div>`;

export class Feed extends View {
  /** tell(sentence) shows why a source could not be opened. @param {HTMLElement} box
   * @param {(sentence: string) => void} tell */
  constructor(box, tell) {
    super(box);
    this.modality = /** @type {Modality} */ (box.dataset.modality);
    this.term = TERMS[this.modality].one;
    this.video = Object.assign(document.createElement("video"), { muted: true, loop: true, playsInline: true });
    this.canvas = /** @type {HTMLCanvasElement} */ (this.$("canvas"));
    /** Of this camera, as its picture is: no view reads it. @type {Rest | null} */
    this.rest = null;
    this.opening = {};
    this.active = false; // a source chosen while Live runs opens at once
    const { device, crop, turn } = (this.menus = Object.fromEntries(
      Object.keys(MENUS).map((name) => [name, /** @type {HTMLSelectElement} */ (this.$(`.${name}`))]),
    ));
    this.clip = /** @type {HTMLInputElement} */ (this.$(".clip"));
    const open = () => this.active && attempt(() => this.open(), tell);
    this.clip.onchange = open;
    device.onchange = () => (device.value === "file" ? this.clip.click() : open());
    this.wanted = keptJson(KEPT + this.modality, {});
    for (const menu of [crop, turn]) menu.value = this.wanted[menu.className] ?? menu.value;
    box.onchange = ({ target }) => {
      if (target === this.clip) return;
      const source = device.value ? device.selectedOptions[0].text : "none";
      this.wanted = { device: device.value === "file" ? "" : source, crop: crop.value, turn: turn.value };
      keep(KEPT + this.modality, JSON.stringify(this.wanted));
    };
  }

  get on() {
    return this.video.videoWidth > 0;
  }

  /** Offer the devices by name; the remembered one is chosen, else the first that `taken` does not have.
   * @param {MediaDeviceInfo[]} devices @param {Set<string>} taken */
  offer(devices, taken) {
    const { device } = this.menus;
    const cameras = devices.map(({ deviceId, label }) => [deviceId, label || "camera"]);
    put(device, options([...MENUS.device[1], ...cameras]));
    const known =
      devices.find(({ label }) => label === this.wanted.device) ?? devices.find(({ deviceId }) => !taken.has(deviceId));
    device.value = this.wanted.device === "none" ? "" : (known?.deviceId ?? "");
    taken.add(device.value);
  }

  /** What a no-contact picture depends on: source, crop, turn and size. */
  get shape() {
    const menus = Object.values(this.menus).map(({ value }) => value);
    return [...menus, this.clip.files?.[0]?.name, this.video.videoWidth, this.video.videoHeight].join();
  }

  /** Tell what became of the no-contact picture or the source; it stays until something else does.
   * @param {string} sentence */
  say(sentence) {
    this.$(".state").textContent = sentence;
  }

  /** Open the chosen source, unless another one is opened or this one closed meanwhile. */
  async open() {
    this.close();
    const { video, opening } = this;
    const { value } = this.menus.device;
    const file = this.clip.files?.[0];
    if (!value || (value === "file" && !file)) return;
    if (value === "file" && file) video.src = URL.createObjectURL(file);
    else {
      const stream = await camera({ deviceId: { exact: value } });
      if (opening !== this.opening) return stopped(stream);
      video.srcObject = stream;
      stream.getVideoTracks()[0].onended = () => {
        this.close();
        this.say(`The camera of the ${this.term} was disconnected.`);
      };
    }
    try {
      await video.play();
    } catch {
      if (opening !== this.opening) return;
      throw new Refusal(`This source of the ${this.term} cannot be played here; choose another camera or video.`);
    }
  }

  close() {
    const { video } = this;
    this.opening = {}; // another one each time
    if (video.srcObject instanceof MediaStream) stopped(video.srcObject);
    video.srcObject = null;
    video.removeAttribute("src");
    video.load();
  }

  /** Draw the newest frame, cropped and turned. Returns whether it touches something: null without a no-contact
   * picture. */
  draw() {
    const { video, canvas } = this;
    if (this.rest && this.rest.shape !== this.shape) {
      this.rest = null;
      this.say(
        `The no-contact picture of the ${this.term} was dropped: its source, crop, turn or size changed. ` +
          "Take it again.",
      );
    }
    const { crop, turn } = this.menus;
    const kept = CROPS[crop.value][1](video.videoWidth, video.videoHeight);
    const scale = SIDE / Math.max(...kept);
    const size = kept.map((length) => Math.max(1, Math.round(length * scale)));
    [canvas.width, canvas.height] = +turn.value % 180 ? size.toReversed() : size;
    const context = drawingOn(canvas, { willReadFrequently: true });
    context.translate(canvas.width / 2, canvas.height / 2);
    context.rotate((+turn.value * Math.PI) / 180);
    const [x, y] = [video.videoWidth - kept[0], video.videoHeight - kept[1]];
    const [wide, high] = size;
    context.drawImage(video, x / 2, y / 2, ...kept, -wide / 2, -high / 2, wide, high);
    return this.rest ? apart(grey(canvas), this.rest.mean) > this.rest.limit : null;
  }

  /** @returns {Promise<Blob>} */
  blob(type = "image/jpeg") {
    return new Promise((resolve) => this.canvas.toBlob((blob) => resolve(/** @type {Blob} */ (blob)), type, 0.92));
  }

  /** Wait for a new frame, or a moment. */
  fresh() {
    return new Promise((done) => {
      setTimeout(done, LATE);
      this.video.requestVideoFrameCallback?.(done);
    });
  }

  /** Take the no-contact picture: the mean of some frames, and their noise. onFrame(n) gets the number so far.
   * @param {(n: number) => void} onFrame */
  async takeRest(onFrame) {
    this.rest = null;
    const frames = [];
    const { shape } = this; // another one drops the picture
    while (frames.length < FRAMES) {
      await this.fresh();
      if (!this.on) return;
      this.draw();
      frames.push(grey(this.canvas));
      onFrame(frames.length);
    }
    const rest = restOf(frames);
    this.rest = rest && { shape, ...rest };
    this.say(
      rest
        ? `The no-contact picture is the mean of ${FRAMES} frames.`
        : "No picture was kept, because the frames differ as if the sensor was touched. Take it again without " +
            "touching the sensor.",
    );
  }
}

/** @param {MediaStream} stream */
function stopped(stream) {
  for (const track of stream.getTracks()) track.stop();
}

/** @param {HTMLCanvasElement} canvas */
const grey = (canvas) => blocksOf(drawingOn(canvas).getImageData(0, 0, canvas.width, canvas.height));

/** Mean grey level of each of GRID x GRID blocks of a picture.
 * @param {Pick<ImageData, "data" | "width" | "height">} picture */
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
 * @param {Float32Array} one @param {Float32Array} other
 */
export function apart(one, other) {
  const changes = one.map((value, i) => value - other[i]);
  const median = changes.toSorted()[changes.length >> 1];
  return Math.max(...changes.map((change) => Math.abs(change - median)));
}

/** The no-contact picture of some frames and the limit beyond which a picture is a contact; null if they differ as by a
 * touch.
 * @param {Float32Array[]} frames */
export function restOf(frames) {
  const mean = frames[0].map((_, i) => meanOf(frames.map((one) => one[i])));
  const noise = Math.max(...frames.map((one) => apart(one, mean)));
  return noise > LEAST ? null : { mean, limit: Math.max(LEAST, NOISE * noise) };
}
