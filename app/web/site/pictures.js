/** The routes whose body is a file: own pictures, the camera, hidden parts, a saved profile. Runs in the worker. */

import { drawingOn } from "../shared/canvas.js";
import { IMAGES, OTHER } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { decoded } from "./decode.js";
import { nameOf } from "./desk.js";
import { loaded } from "./profiles.js";
import { PICTURE } from "./rules.js";
import { rounded, roundedRow, rowsOf } from "./tensors.js";

const { HIDDEN, PREVIEW } = PICTURE;
const WARM = 3; // runs after which the browser has compiled the encoder
/** @typedef {import("./desk.js").Desk} Desk */

/** A small copy, as a data address. @param {Desk} desk @param {Raster} picture */
async function preview(desk, picture) {
  const { pixels, width, height } = await desk.within(picture, PREVIEW);
  const data = new ImageData(width, height);
  data.data.fill(255);
  pixels.forEach((value, at) => (data.data[at + Math.floor(at / 3)] = value));
  const canvas = new OffscreenCanvas(width, height);
  drawingOn(canvas).putImageData(data, 0, 0);
  const blob = await canvas.convertToBlob({ type: "image/jpeg", quality: 0.85 });
  return new /** @type {any} */ (self).FileReaderSync().readAsDataURL(blob);
}

/** @type {Record<string, Route>} */
export const PICTURES = {
  /** Embed a visitor's picture; its reference, its size and a small copy. */
  async image(desk, { name = "" }, { body }) {
    const ref = `image:${nameOf(body)}`;
    const picture = await decoded(body, name.slice(0, 120) || "the image");
    if (!desk.given.has(ref)) desk.given.set(ref, await desk.asEither(picture));
    const [width, height] = picture.full;
    return { ref, width, height, preview: await preview(desk, picture) };
  },

  /** Fetch the encoder, and run what a first pair needs: later ones wait for no file and no compiler. */
  async warm(desk) {
    await desk.runtime(); // with the head, before the encoder
    await desk.encoder();
    const blank = { pixels: new Uint8Array(3 * 320 * 240), width: 320, height: 240 };
    for (let time = 0; time < WARM; time++) await desk.predicted(await desk.asked({}, await desk.asEither(blank)));
    return {};
  },

  async live(desk, question, { body }) {
    const { modality, split } = question;
    const parts = modality === "both" ? [body.subarray(0, split), body.subarray(split)] : [body];
    const names = modality === "both" ? IMAGES : [/** @type {Modality} */ (modality)];
    const pictures = [];
    for (const [i, part] of parts.entries()) pictures.push(await desk.seen(await decoded(part), names[i]));
    const read = performance.now();
    /** @type {Rows} */
    const rows = {};
    for (const [i, picture] of pictures.entries()) rows[names[i]] = await desk.encoded(picture);
    const embedded = performance.now();
    const asked = await desk.asked(question, rows);
    const reply = await desk.predicted(asked);
    const since = (/** @type {number} */ from, to = performance.now()) => rounded(to - from, 1);
    const ms = { encoder: since(read, embedded), head: since(embedded) };
    return { classes: asked.head.classes, ...reply, ms };
  },

  /** Hide each part of a picture in turn, and predict again. */
  async occlusion(desk, question, { body, stopped }) {
    const modality = /** @type {Modality} */ (question.modality);
    const beside = { ...question, [OTHER[modality]]: question.other };
    const picture = await desk.within(await decoded(body), HIDDEN);
    const { pixels, width, height } = picture;
    const { pixels: grey } = await desk.resized(picture, 1, 1);
    const whole = { values: pixels, shape: [1, height, width, 3] };
    const [parts] = await desk.rule("parts", whole, { values: grey, shape: [1, 1, 1, 3] });
    const { classes } = await desk.reader(question);
    const predicted = async (/** @type {Uint8Array} */ shown) => {
      if (stopped()) throw new Refusal("The request was withdrawn.", 499);
      const row = await desk.encoded(await desk.seen({ pixels: shown, width, height }, modality));
      return (await desk.readings(await desk.asked(beside, { [modality]: row }))).fused;
    };
    const fused = await predicted(pixels);
    const top = fused.indexOf(Math.max(...fused));
    const falls = [];
    for (let at = 0; at < parts.values.length; at += pixels.length)
      falls.push(fused[top] - (await predicted(parts.values.slice(at, at + pixels.length)))[top]);
    const [drops] = await desk.rule("drops", Float32Array.from(falls));
    return { class: classes[top], probability: rounded(fused[top]), drops: rowsOf(drops).map(roundedRow) };
  },

  async sensor(desk, _, { body }) {
    const { key, width } = await desk.about();
    const profile = loaded(body, key, width);
    await desk.sourceProfile();
    return desk.keepProfile(profile);
  },
};
