/** The visitor’s own pictures: from files, a camera or the address, sent once, and what they are called. */

import { attempt, Refusal, sendImage } from "../shared/api.js";
import { drawingOn } from "../shared/canvas.js";
import { links, state } from "../shared/store.js";
import { NO_CLASS } from "../shared/text.js";
import { TERMS } from "./verdict.js";

const LARGEST = 20e6; // bytes
/** Reference -> the server's reply, and the name. */
export const sent = new Map();

/** Upload a file; of many, the page keeps no preview. */
export async function upload(file, signal) {
  if (file.size > LARGEST)
    throw new Refusal(
      `'${file.name}' has ${(file.size / 1e6).toFixed(0)} MB; the limit is 20 MB. Scale it down and try again.`,
    );
  const { ref, width, height, preview } = await sendImage(file, file.name, signal);
  sent.set(ref, { name: file.name, width, height, ...(signal ? { file } : { preview }) });
  return ref;
}

const inside = (folder) => {
  const reader = folder.createReader();
  return new Promise((resolve, reject) => {
    const all = [];
    const more = () =>
      reader.readEntries((some) => {
        all.push(...some);
        if (some.length) more();
        else resolve(all);
      }, reject);
    more();
  });
};

async function filesOf(entry, path = "") {
  const name = path + entry.name;
  if (entry.isFile) return [{ path: name, file: await new Promise((resolve, reject) => entry.file(resolve, reject)) }];
  const all = [];
  for (const one of await inside(entry)) all.push(...(await filesOf(one, `${name}/`)));
  return all;
}

/** [{path, file}] of a drop. */
export async function droppedFiles(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean); // before any wait
  if (!entries.some((entry) => entry.isDirectory)) return chosenFiles(transfer.files);
  return (await Promise.all(entries.map((entry) => filesOf(entry)))).flat();
}

/** [{path, file}] of a file field. */
export const chosenFiles = (files) => [...files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));

/** Open a camera; throws a Refusal if there is none. */
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

/** Show the camera in `box` until a picture is taken. Returns its PNG, or null if cancelled. */
export async function snapshot(box) {
  const stream = await camera();
  const before = box.innerHTML;
  box.innerHTML =
    '<video autoplay playsinline muted></video><div class="row"><button type="button" class="main">Take it</button><button type="button">Cancel</button></div>';
  const video = box.querySelector("video");
  video.srcObject = stream;
  const [takeIt, cancel] = box.querySelectorAll("button");
  takeIt.focus();
  try {
    return await new Promise((resolve) => {
      cancel.onclick = () => resolve(null);
      takeIt.onclick = () => {
        const canvas = document.createElement("canvas");
        canvas.width = video.videoWidth;
        canvas.height = video.videoHeight;
        drawingOn(canvas).drawImage(video, 0, 0);
        canvas.toBlob(resolve, "image/png");
      };
    });
  } finally {
    stream.getTracks().forEach((track) => track.stop());
    box.innerHTML = before;
  }
}

const REFERENCE = /^(row|example|image):/;

/** Send the pictures of the address; they then are references like others. Returns what went wrong, one sentence. */
export async function takeLinked() {
  const problems = await Promise.all(Object.keys(TERMS).map(takeOne));
  return problems.filter(Boolean).join(" ");
}

async function takeOne(modality) {
  const link = state[modality];
  let problem = "";
  if (!link || REFERENCE.test(link)) return problem;
  state[modality] = null;
  await attempt(
    async () => {
      const ref = await upload(await fetched(link, TERMS[modality].one));
      links.set(link, ref);
      state[modality] = ref;
    },
    (sentence) => (problem = sentence),
  );
  return problem;
}

/** The file at a link; a picture of another host is not fetched. */
async function fetched(link, what) {
  const url = URL.canParse(link, document.baseURI) ? new URL(link, document.baseURI) : null;
  if (!url || url.origin !== location.origin)
    throw new Refusal(`The ${what} '${link.slice(0, 80)}' is not on this page's host; open its file here instead.`);
  const response = await fetch(url).catch(() => null);
  if (!response?.ok) throw new Refusal(`The ${what} '${link.slice(0, 80)}' cannot be fetched; check its address.`);
  return new File([await response.blob()], decodeURIComponent(url.pathname.replace(/.*\//, "")) || what);
}

export class Known {
  constructor(examples, { frames }) {
    this.examples = examples;
    this.frames = frames;
  }

  /** {text, truth}; truth is undefined for uploaded images. */
  of(ref) {
    const at = ref.indexOf(":");
    const [kind, name] = [ref.slice(0, at), ref.slice(at + 1)];
    if (kind === "example") {
      const example = this.examples.find((one) => one.name === name);
      return { text: example ? `${example.class} · ${example.domain}` : name, truth: example?.class };
    }
    const { frames } = this;
    if (kind === "row" && frames && +name < frames.pairs) {
      const truth = frames.classes[frames.label[+name]];
      if (truth === NO_CLASS) return { text: `pair ${name} · ${frames.domains[frames.domain[+name]]}` };
      return { text: `pair ${name} · ${truth} · ${frames.domains[frames.domain[+name]]}`, truth };
    }
    if (kind === "row") return { text: `pair ${name}` };
    const image = sent.get(ref);
    const credit = image?.credit ? ` · ${image.credit}` : "";
    return { text: image ? `${image.name} · ${image.width} × ${image.height}${credit}` : ref };
  }

  /** A short name for a pair of the visitor's. */
  name({ vis, tac }) {
    const names = [vis, tac].filter(Boolean).map((ref) => sent.get(ref)?.name ?? this.of(ref).text);
    return [...new Set(names)].join(" + ");
  }
}
