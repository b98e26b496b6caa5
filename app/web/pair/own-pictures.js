/** The visitor’s own pictures: from files, a camera or the address, and what they are called. */

import { attempt, hold, Refusal } from "../shared/api.js";
import { drawingOn } from "../shared/canvas.js";
import { classOf, domainOf } from "../shared/frames.js";
import { change, links, state } from "../shared/store.js";
import { sensorOf } from "../shared/tables.js";
import { joined } from "../shared/text.js";
import { IMAGES, NO_CLASS, TERMS } from "./parts.js";

const LARGEST = 20e6; // bytes
const SHOWN = /^image\/(?!tiff)/; // by any browser

/** Take a file: the next request about it sends it. @param {File} file
 * @param {(event: "held", what: Record<Ref, Picture>) => unknown} send */
export async function held(file, send, credit = "") {
  const { name, size } = file;
  if (size > LARGEST)
    throw new Refusal(`'${name}' has ${(size / 1e6).toFixed(0)} MB; the limit is 20 MB. Scale it down and try again.`);
  const ref = await hold(file, name);
  send("held", { [ref]: { name, src: SHOWN.test(file.type) ? URL.createObjectURL(file) : "", credit } });
  return ref;
}

/** All entries of a folder, which a browser gives some at a time.
 * @param {FileSystemDirectoryReader} reader @returns {Promise<FileSystemEntry[]>} */
async function inside(reader) {
  const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
  return some.length ? [...some, ...(await inside(reader))] : [];
}

/** @param {any} entry a file or a folder @returns {Promise<Chosen[]>} */
async function filesOf(entry, path = "") {
  const name = path + entry.name;
  if (entry.isFile) return [{ path: name, file: await new Promise((resolve, reject) => entry.file(resolve, reject)) }];
  const entries = await inside(entry.createReader());
  return (await Promise.all(entries.map((one) => filesOf(one, `${name}/`)))).flat();
}

/** The files of a drop. @param {DataTransfer} transfer */
export async function droppedFiles(transfer) {
  const entries = [...transfer.items].flatMap((item) => item.webkitGetAsEntry?.() ?? []); // before any wait
  if (!entries.some((entry) => entry.isDirectory)) return chosenFiles(transfer.files);
  return (await Promise.all(entries.map((entry) => filesOf(entry)))).flat();
}

/** The files of a file field. @param {Iterable<File>} files @returns {Chosen[]} */
export const chosenFiles = (files) => [...files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));

/** Open a camera; throws a Refusal if there is none. @param {MediaTrackConstraints} which */
export async function camera(which = {}) {
  if (!navigator.mediaDevices?.getUserMedia) {
    throw new Refusal("This browser allows no camera here; open the page on localhost or over https.");
  }
  try {
    return await navigator.mediaDevices.getUserMedia({ video: which });
  } catch {
    throw new Refusal("No camera could be opened; connect one and allow the page to use it.");
  }
}

/** Show a camera in a box with a video and two buttons; return the picture that is taken, null if cancelled.
 * @param {Element} box @param {MediaStream} stream @param {AbortSignal} signal @returns {Promise<Blob | null>} */
export function snapshot(box, stream, signal) {
  const video = /** @type {HTMLVideoElement} */ (box.querySelector("video"));
  const [takeIt, cancel] = box.querySelectorAll("button");
  video.srcObject = stream;
  takeIt.focus();
  return new Promise((resolve) => {
    cancel.onclick = signal.onabort = () => resolve(null);
    takeIt.onclick = () => {
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [video.videoWidth, video.videoHeight];
      drawingOn(canvas).drawImage(video, 0, 0);
      canvas.toBlob(resolve, "image/png");
    };
  });
}

const REFERENCE = /^(row|example|image):/;

/** Take the pictures of the address; they then are references like others. Returns them, and what went wrong as a
 * sentence. */
export async function takeLinked() {
  /** @type {Record<Ref, Picture>} */
  const sent = {};
  /** @type {string[]} */
  const problems = [];
  const keep = (/** @type {string} */ _, /** @type {typeof sent} */ picture) => Object.assign(sent, picture);
  const note = (/** @type {string} */ problem) => problems.push(problem);
  const taking = IMAGES.map(async (modality) => {
    const link = state[modality];
    if (!link || REFERENCE.test(link)) return;
    const file = () => fetched(link, TERMS[modality].one);
    const ref = await attempt(async () => held(await file(), keep), note);
    if (ref) links.set(link, ref);
    change({ [modality]: ref ?? null });
  });
  await Promise.all(taking);
  return { lost: problems.join(" "), sent };
}

/** The file at a link; a picture of another host is not fetched. @param {string} link @param {string} what */
async function fetched(link, what) {
  const named = `The ${what} '${link.slice(0, 80)}'`;
  const url = URL.canParse(link, document.baseURI) ? new URL(link, document.baseURI) : null;
  if (url?.origin !== location.origin)
    throw new Refusal(`${named} is not on this page's host; open its file here instead.`);
  const response = await fetch(url).catch(() => null);
  if (!response?.ok) throw new Refusal(`${named} cannot be fetched; check its address.`);
  return new File([await response.blob()], decodeURIComponent(url.pathname.replace(/.*\//, "")) || what);
}

/** A reference in its parts: ["row", "3"]. @param {Ref} ref */
export const partsOf = (ref) => [ref.slice(0, ref.indexOf(":")), ref.slice(ref.indexOf(":") + 1)];

/** What a picture is called, and its class unless it is the visitor's.
 * @param {Pick<PairTab, "examples" | "set" | "sent">} tab @param {Ref} ref @returns {{text: string, truth?: string}} */
export function describe({ examples, sent, set: { frames } }, ref) {
  const [kind, name] = partsOf(ref);
  const dotted = (/** @type {unknown[]} */ ...words) => joined(words, " · ");
  if (kind === "example") {
    const example = examples.find((one) => one.name === name);
    return { text: example ? dotted(example.class, sensorOf(example.domain)) : name, truth: example?.class };
  }
  if (kind === "row") {
    const there = frames && +name < frames.pairs;
    if (frames && !there) return { text: `This set has no pair ${name}.` };
    const label = there ? classOf(frames, +name) : NO_CLASS;
    const truth = label === NO_CLASS ? "" : label;
    return { text: dotted(`pair ${name}`, truth, there && sensorOf(domainOf(frames, +name))), truth };
  }
  const image = sent[ref];
  return {
    text: image
      ? dotted(image.name, image.width && `${image.width}\u00a0×\u00a0${image.height}`, image.credit)
      : "A picture from an earlier visit",
  };
}
