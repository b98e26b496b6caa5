/** The routes whose body is a file: own pictures, the camera, hidden parts, a saved profile. Runs in the worker. */

import { drawingOn } from "../shared/canvas.js";
import { OTHER } from "../shared/images.js";
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
import { best, rounded, sum } from "./tensors.js";

const CELLS = 7; // of a side, in Where?
const PATCH = 2; // cells of a hidden part's side
const STEPS = CELLS - PATCH + 1;
const WARM = 3; // runs after which the browser has compiled the encoder

/** Embed a visitor's picture; its reference, its size and a small copy. */
async function image(desk, { body, query }) {
  const name = (query.get("name") ?? "").slice(0, 120) || "the image";
  const ref = `image:${nameOf(body)}`;
  const picture = await decoded(body, name);
  if (!desk.sent.has(ref)) desk.sent.set(ref, await desk.models.asEither(picture));
  const [width, height] = picture.full;
  return { ref, width, height, preview: await preview(desk, picture) };
}

async function preview(desk, picture) {
  const { pixels, width, height } = await desk.models.within(picture, 320);
  const data = new ImageData(width, height);
  data.data.fill(255);
  pixels.forEach((value, at) => (data.data[at + Math.floor(at / 3)] = value));
  const canvas = new OffscreenCanvas(width, height);
  drawingOn(canvas).putImageData(data, 0, 0);
  const blob = await canvas.convertToBlob({ type: "image/jpeg", quality: 0.85 });
  return new /** @type {any} */ (self).FileReaderSync().readAsDataURL(blob);
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
  const [modality, name, reader, profile, ref] = ["modality", "taught", "head", "profile", "other"].map(
    (key) => query.get(key) ?? "",
  );
  const head = name ? desk.taught.get(name) : await desk.models.head(reader);
  if (!head) throw new Refused("The page no longer has the taught head; press Teach again.", 410);
  const question = { profile, head: reader, lessons: head.lessons };
  const rest = ref && OTHER[modality];
  const other = async (by) => (rest ? { [rest]: await embedding(desk, ref, rest, by) } : {});
  return { modality, head, order: orderIn(query.get("order")), question, other };
}

async function live(desk, { body, query }) {
  const began = performance.now();
  const { modality, head, order, question, other } = await asked(desk, query);
  const split = Number(query.get("split"));
  const parts =
    modality === "both" ? { vis: body.subarray(0, split), tac: body.subarray(split) } : { [modality]: body };
  const pictures = {};
  for (const [name, part] of Object.entries(parts)) pictures[name] = await desk.models.seen(await decoded(part), name);
  const read = performance.now();
  const [rows, before] = [{}, {}];
  for (const [name, picture] of Object.entries(pictures)) {
    before[name] = await desk.models.encoded(picture);
    rows[name] = await movedBy(desk, question, name, before[name]);
  }
  const embedded = performance.now();
  Object.assign(rows, await other(question));
  Object.assign(before, await other({}));
  const found = await predictOne(desk, head, rows, { before, order, question });
  const ms = [read - began, embedded - read, performance.now() - embedded];
  const [decoding, encoder, last] = rounded(ms, 1);
  return { classes: head.classes, ...found, ms: { read: decoding, encoder, head: last } };
}

/** Hide each part of a picture in turn, and predict again. */
async function occlusion(desk, { body, query, stopped }) {
  const { modality, head, order, question, other } = await asked(desk, query);
  const began = performance.now();
  const { models } = desk;
  const picture = await models.within(await decoded(body), 448);
  const { pixels, width, height } = picture;
  const { pixels: mean } = await models.resized(picture, 1, 1);
  const rest = await other(question);
  const predicted = async (shown) => {
    if (stopped()) throw new Refused("The request was withdrawn.", 499);
    const row = await models.encoded(await models.seen(shown, modality));
    const rows = { ...rest, [modality]: await movedBy(desk, question, modality, row) };
    const out = await models.run(head, rows, [order === null ? learned(head) : [order, order]]);
    return readingsOf(head, out, 0, rows).fused;
  };
  const first = await predicted(picture);
  const top = best(first);
  const falls = [];
  const edge = (cell, side) => Math.floor((cell * side) / CELLS);
  for (let at = 0; at < STEPS * STEPS; at++) {
    const [row, column] = [Math.floor(at / STEPS), at % STEPS];
    const copy = pixels.slice();
    for (let y = edge(row, height); y < edge(row + PATCH, height); y++)
      for (let x = edge(column, width); x < edge(column + PATCH, width); x++) copy.set(mean, 3 * (y * width + x));
    falls.push(first[top] - (await predicted({ pixels: copy, width, height }))[top]);
  }
  return {
    class: head.classes[top],
    probability: rounded([first[top]])[0],
    cells: CELLS,
    drops: overCells(falls),
    seconds: rounded([(performance.now() - began) / 1000], 2)[0],
  };
}

/** The mean decrease for each cell, over the parts that cover it. */
function overCells(falls) {
  const cells = Array.from({ length: CELLS }, (_, i) => i);
  const covers = (part, cell) => part <= cell && cell < part + PATCH;
  return cells.map((row) =>
    cells.map((column) => {
      const over = falls.filter((_, at) => covers(Math.floor(at / STEPS), row) && covers(at % STEPS, column));
      return rounded([sum(over) / over.length])[0];
    }),
  );
}

async function sensor(desk, { body }) {
  const { key } = await desk.models.about();
  await sourceProfile(desk);
  return keptProfile(desk, profileFrom(body.slice().buffer, key));
}

export const FILES = { image, live, occlusion, sensor };
