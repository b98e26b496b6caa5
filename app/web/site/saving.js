/** What a visitor saves of teaching: the labelled pairs as a set, and the taught head; files as the server's. */

import { zipped } from "../pair/zip.js";
import { csv } from "../shared/csv.js";
import { IMAGES } from "../shared/images.js";
import { embedding, headFor } from "./desk.js";
import { Refused } from "./refusal.js";
import { lessonsIn } from "./teaching.js";
import { file, floats, norm, raw, unit, wholes } from "./tensors.js";

const DOMAIN = "My pairs";
const ORIGIN = "labelled by a visitor of the page";
const ROWS = ["vis", "tac", "object", "split", "part", "looks_like", "feels_like"];
const HEAD_NOTE = (name) => `A head made in the OmniVaT page.

python app.py --head ${name}
python -m omnivat evaluate --head ${name} --embeddings FILE
`;
const SET_NOTE = (name) => `A set of embeddings made in the OmniVaT page. It holds no images.

python app.py --embeddings ${name}/embeddings.safetensors
python -m omnivat train --embeddings ${name}/embeddings.safetensors --source DOMAIN --out my-head
`;
const text = (value) => new TextEncoder().encode(typeof value === "string" ? value : JSON.stringify(value, null, 2));

/** One zip of files in a folder. */
async function archive(name, files) {
  const parts = zipped(Object.entries(files).map(([path, bytes]) => [`${name}/${path}`, bytes]));
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

async function saveSet(desk, question) {
  const given = lessonsIn(question).filter(({ vis, tac }) => vis && tac);
  if (!given.length) throw new Refused("A set needs pairs of both images; label at least one photo with its touch.");
  const { key, width } = await desk.models.about();
  const labels = given.map(({ label }) => label.trim());
  const classes = [...new Set(labels)];
  const rows = Object.fromEntries(ROWS.map((name) => [name, labels.map(() => "")]));
  const vectors = { vis: new Float32Array(labels.length * width), tac: new Float32Array(labels.length * width) };
  for (const [number, one] of given.entries()) {
    const object = `${DOMAIN}/${labels[number]}/${number}`;
    rows.object[number] = object;
    for (const name of IMAGES) {
      rows[name][number] = `${object}_${name}.png`;
      vectors[name].set(await embedding(desk, one[name], name, {}), number * width); // a profile is a file of its own
    }
  }
  const shape = [labels.length, width];
  const entries = {
    vis: floats(vectors.vis, shape),
    tac: floats(vectors.tac, shape),
    domain: wholes(labels.map(() => 0)),
    label: wholes(labels.map((label) => classes.indexOf(label))),
    rows: { dtype: "U8", shape: [text(JSON.stringify(rows)).length], bytes: text(JSON.stringify(rows)) },
  };
  const metadata = {
    ...{ format: "omnivat-embeddings-1", encoder: key.name, weights_hash: key.weights_hash },
    ...{ preprocessing: key.preprocessing, precision: "fp32", domains: JSON.stringify([DOMAIN]) },
    ...{ classes: JSON.stringify(classes), simulated: "false", origin: ORIGIN },
    ...{ pairs: `${labels.length}`, width: `${width}` },
  };
  const table = [
    ["domain", "material", ...ROWS],
    ...labels.map((label, i) => [DOMAIN, label, ...ROWS.map((name) => rows[name][i])]),
  ];
  const name = "my-pairs";
  return archive(name, {
    "embeddings.safetensors": file(entries, metadata),
    "embeddings.csv": text(csv(table)),
    "README.txt": text(SET_NOTE(name)),
  });
}

/** The weights of a head with the classes and deciding rows of the taught one. */
function taughtWeights(entries, head) {
  const { taught_alone_rows: _rows, taught_alone_bias: _bias, ...kept } = entries; // of linear maps of one image
  const { classifier, "mffa.bank": bank, "mffa.bank_seen": seen } = kept;
  const [classes, wide] = classifier.shape;
  const old = new Float32Array(classifier.bytes.slice().buffer);
  const row = (k) => old.subarray(k * wide, (k + 1) * wide);
  const mean = head.classes.reduce((total, _, k) => total + (k < classes ? norm(row(k)) / classes : 0), 0);
  const rows = head.directions.map((one, k) => (k < classes ? [...row(k)] : Array.from(unit(one), (x) => mean * x)));
  const found = { ...kept, classifier: floats(Float32Array.from(rows.flat()), [rows.length, wide]) };
  if (bank && rows.length > classes) {
    const [many, , width] = bank.shape; // new classes have no token of their own
    const before = new Float32Array(bank.bytes.slice().buffer);
    const after = new Float32Array(many * rows.length * width);
    for (let m = 0; m < many; m++)
      after.set(before.subarray(m * classes * width, (m + 1) * classes * width), m * rows.length * width);
    found["mffa.bank"] = floats(after, [many, rows.length, width]);
    found["mffa.bank_seen"] = {
      dtype: "BOOL",
      shape: [rows.length],
      bytes: Uint8Array.of(...seen.bytes, ...new Array(rows.length - classes).fill(0)),
    };
  }
  const width = head.rows[0].length / 2;
  const halves = [0, width].flatMap((from) => head.rows.map((row) => row.subarray(from, from + width)));
  const flat = new Float32Array(halves.length * width);
  halves.forEach((half, at) => flat.set(half, at * width));
  return {
    ...found,
    taught_rows: floats(flat, [2, head.rows.length, width]),
    taught_bias: floats(Float32Array.from(head.bias), [head.bias.length]),
    taught_class: wholes(head.owner),
  };
}

async function saveHead(desk, question) {
  const lessons = lessonsIn(question);
  if (!lessons.length) throw new Refused("No pair is labelled yet, so there is no taught head to save.");
  const head = await headFor(desk, question);
  const bytes = async (name) => new Uint8Array(await desk.models.fetch(new URL(name, desk.models.folder)));
  const { parts } = await desk.models.head(question.head);
  const settings = JSON.parse(new TextDecoder().decode(await bytes(parts.settings)));
  const counts = {};
  for (const { label } of lessons) counts[label.trim()] = (counts[label.trim()] ?? 0) + 1;
  settings.head = { ...settings.head, classes: head.classes, taught: head.rows.length, taught_alone: false };
  settings.provenance = { ...settings.provenance, taught: counts, lessons_share: head.share };
  const entries = taughtWeights(raw((await bytes(parts.weights)).buffer), head);
  const name = "taught-head";
  const files = {
    "weights.safetensors": file(entries, { format: "omnivat-head-1" }),
    "settings.json": text(settings),
    "metrics.json": text("{}\n"),
    "README.txt": text(HEAD_NOTE(name)),
  };
  for (const one of ["familiarity", "profile"]) if (parts[one]) files[`${one}.safetensors`] = await bytes(parts[one]);
  return archive(name, files);
}

export const SAVING = { "save/set": saveSet, "save/head": saveHead };
