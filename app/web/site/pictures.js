/** The routes whose body is a file: own pictures, the camera, hidden parts, a saved profile. Runs in the worker. */

import { drawingOn } from "../shared/canvas.js";
import { OTHER } from "../shared/images.js";
import { base64 } from "../shared/text.js";
import { decoded } from "./decode.js";
import {
  embedding,
  keptProfile,
  learned,
  movedBy,
  nameOf,
  orderIn,
  predictOne,
  readingsOf,
  sourceProfile,
} from "./desk.js";
import { profileFrom } from "./profiles.js";
import { Refused } from "./refusal.js";
import { resized, thumbnail } from "./resize.js";
import { best, rounded } from "./tensors.js";

const CELLS = 7; // of a side, in Where?
const PATCH = 2;
const WARM = 3; // runs after which the browser has compiled the encoder

/** Embed a visitor's picture; its reference, its size and a small copy. */
async function image(desk, { body, query }) {
  const name = (query.get("name") ?? "").slice(0, 120) || "the image";
  const ref = `image:${nameOf(body)}`;
  const picture = await decoded(body, name);
  if (!desk.sent.has(ref)) desk.keep(desk.sent, ref, await desk.models.asEither(picture));
  const [width, height] = picture.full;
  return { ref, width, height, preview: await preview(picture) };
}

async function preview(picture) {
  const { pixels, width, height } = thumbnail(picture, 320);
  const canvas = new OffscreenCanvas(width, height);
  const data = new ImageData(width, height);
  for (let i = 0; i < width * height; i++) {
    data.data.set(pixels.subarray(3 * i, 3 * i + 3), 4 * i);
    data.data[4 * i + 3] = 255;
  }
  drawingOn(canvas).putImageData(data, 0, 0);
  const blob = await canvas.convertToBlob({ type: "image/jpeg", quality: 0.85 });
  return `data:image/jpeg;base64,${base64(new Uint8Array(await blob.arrayBuffer()))}`;
}

/** Fetch the encoder, and run once what a first pair needs: later ones wait for no file and no compiler. */
export async function warm(desk) {
  await desk.models.runtime(); // with the head, before the encoder
  const canvas = new OffscreenCanvas(320, 240);
  drawingOn(canvas).fillRect(0, 0, 160, 120);
  const blob = await canvas.convertToBlob({ type: "image/jpeg" });
  const body = new Uint8Array(await blob.arrayBuffer());
  const head = await desk.models.head();
  for (let time = 0; time < WARM; time++) {
    const { ref } = await image(desk, { body, query: new URLSearchParams() });
    const row = desk.sent.get(ref);
    desk.sent.delete(ref);
    await predictOne(desk, head, row);
  }
  return {};
}

/** What the address of a picture's request names: the head, the other image, p. */
async function asked(desk, query) {
  const modality = query.get("modality") ?? "";
  if (!["vis", "tac", "both"].includes(modality))
    throw new Refused(`modality is '${modality.slice(0, 20)}'; it is vis, tac or both.`);
  const name = query.get("taught") ?? "";
  const reader = query.get("head") ?? "";
  const head = name ? desk.taught.get(name) : await desk.models.head(reader);
  if (!head) throw new Refused("The page no longer has the taught head; press Teach again.", 410);
  const profile = query.get("profile") ?? "";
  const rest = OTHER[modality];
  const other =
    rest && query.get("other") ? await embedding(desk, query.get("other"), rest, { profile, head: reader }) : null;
  return { modality, head, order: orderIn(query.get("order")), asked: { profile, head: reader }, rest, other };
}

async function live(desk, { body, query }) {
  const began = performance.now();
  const { modality, head, order, asked: question, rest, other } = await asked(desk, query);
  const split = Number(query.get("split"));
  if (modality === "both" && !(split > 0 && split < body.length))
    throw new Refused(`split is ${split}; give the bytes of the photo, before those of the touch.`);
  const parts =
    modality === "both" ? { vis: body.subarray(0, split), tac: body.subarray(split) } : { [modality]: body };
  const pictures = {};
  for (const [name, part] of Object.entries(parts)) pictures[name] = await desk.models.seen(await decoded(part), name);
  const read = performance.now();
  /** @type {Record<string, any>} */
  const rows = { vis: null, tac: null };
  /** @type {Record<string, any>} */
  const before = { vis: null, tac: null };
  for (const [name, one] of Object.entries(pictures)) {
    before[name] = await desk.models.encoded(one);
    rows[name] = await movedBy(desk, question, name, before[name]);
  }
  const embedded = performance.now();
  if (other) {
    rows[rest] = other;
    before[rest] = await embedding(desk, query.get("other"), rest, {});
  }
  const found = await predictOne(desk, head, rows, { before, order, question });
  const ms = { read: read - began, encoder: embedded - read, head: performance.now() - embedded };
  return {
    classes: head.classes,
    ...found,
    ms: Object.fromEntries(Object.entries(ms).map(([name, value]) => [name, rounded([value], 1)[0]])),
  };
}

/** Hide each part of a picture in turn, and predict again. */
async function occlusion(desk, { body, query, stopped }) {
  const { modality, head, order, asked: question, rest, other } = await asked(desk, query);
  const began = performance.now();
  const picture = thumbnail(await decoded(body), 448);
  const { pixels, width, height } = picture;
  const mean = resized(picture, 1, 1).pixels;
  const steps = CELLS - PATCH + 1;
  const predicted = async (one) => {
    if (stopped()) throw new Refused("The request was withdrawn.", 499);
    const own = await movedBy(
      desk,
      question,
      modality,
      await desk.models.encoded(await desk.models.seen(one, modality)),
    );
    const rows = { vis: null, tac: null, [modality]: own, ...(other && { [rest]: other }) };
    const out = await desk.models.run(head, rows, [order === null ? learned(head) : [order, order]]);
    return readingsOf(head, out, 0, rows).fused;
  };
  const first = await predicted(picture);
  const top = best(first);
  const falls = [];
  for (let at = 0; at < steps * steps; at++) {
    const [row, column] = [Math.floor(at / steps), at % steps];
    const copy = pixels.slice();
    const edge = (cell, side) => Math.floor((cell * side) / CELLS);
    for (let y = edge(row, height); y < edge(row + PATCH, height); y++)
      for (let x = edge(column, width); x < edge(column + PATCH, width); x++) copy.set(mean, 3 * (y * width + x));
    falls.push(first[top] - (await predicted({ pixels: copy, width, height }))[top]);
  }
  return {
    class: head.classes[top],
    probability: rounded([first[top]])[0],
    cells: CELLS,
    drops: overCells(falls, steps),
    seconds: rounded([(performance.now() - began) / 1000], 2)[0],
  };
}

/** The mean decrease for each cell, over the parts that cover it. */
export function overCells(falls, steps) {
  const cells = Array.from({ length: CELLS }, (_, i) => i);
  const covers = (part, cell) => part <= cell && cell < part + PATCH;
  return cells.map((row) =>
    cells.map((column) => {
      const own = falls.filter((_, at) => covers(Math.floor(at / steps), row) && covers(at % steps, column));
      return rounded([own.reduce((a, b) => a + b, 0) / own.length])[0];
    }),
  );
}

async function sensor(desk, { body }) {
  const { key } = await desk.models.about();
  await sourceProfile(desk);
  return keptProfile(desk, profileFrom(body.slice().buffer, key));
}

export const FILES = { image, live, occlusion, sensor };
