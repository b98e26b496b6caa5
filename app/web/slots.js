/** The two places for images: choose, drop, paste, webcam; a file goes to the server once. */

import { address, refused, sendImage } from "./api.js";
import { thumbnail } from "./card.js";
import { escaped } from "./text.js";
import { goLive } from "./live.js";
import { snapshot } from "./webcam.js";
import { where } from "./where.js";

const NAMES = { vis: ["VIS", "a photo of the surface"], tac: ["TAC", "the touch sensor’s image"] };
const LARGEST = 20e6;
export const sent = new Map(); // reference -> what the server said of an image of this visit

export function slots(box, { onRef, onProblem, onLive, liveQuestion }) {
  box.innerHTML = Object.entries(NAMES).map(([key, [name, what]]) => `
    <div class="slot panel" data-modality="${key}" tabindex="0" aria-label="${name}: ${what}. Drop or paste an image here.">
      <h3><span class="sign ${key}"></span>${name} <small>${what}</small></h3>
      <div class="picture"><span>Drop or paste an image</span></div>
      <p class="what">&nbsp;</p>
      <div class="row"><label class="choose">Choose file<input type="file" accept="image/*,.tif,.tiff,.webp,.png,.jpg" aria-label="Choose a ${name} image"></label>
      <button type="button" class="camera" title="Take one picture">Camera</button><button type="button" class="live" aria-pressed="false" title="Answer the camera’s pictures one after the other">Live</button><button type="button" class="where" title="Hide one part after the other and see what the answer loses">Where?</button><button type="button" class="clear" aria-label="Remove ${name}">Remove</button></div>
    </div>`).join("");
  for (const slot of box.children) wire(slot);

  function wire(slot) {
    const { modality } = slot.dataset;
    const input = slot.querySelector("input");
    input.onchange = () => input.files[0] && take(input.files[0], input.files[0].name).finally(() => { input.value = ""; });
    slot.ondragover = (event) => {
      event.preventDefault();
      slot.classList.add("over");
    };
    slot.ondragleave = () => slot.classList.remove("over");
    slot.ondrop = (event) => {
      event.preventDefault();
      slot.classList.remove("over");
      const file = event.dataTransfer.files[0];
      if (file) take(file, file.name);
    };
    slot.onpaste = (event) => {
      const file = [...event.clipboardData.files][0];
      if (file) take(file, file.name || "the pasted image");
    };
    slot.querySelector(".clear").onclick = () => onRef(modality, null);
    slot.querySelector(".camera").onclick = async () => {
      try {
        const picture = await snapshot(slot.querySelector(".picture"));
        if (picture) await take(picture, "the webcam’s image");
      } catch (error) {
        refused(error, onProblem);
      }
    };

    let stop = null;
    slot.querySelector(".live").onclick = async () => {
      onProblem("");
      if (stop) return quiet();
      const place = slot.querySelector(".picture");
      place.innerHTML = '<video autoplay playsinline muted></video>';
      slot.querySelector(".live").setAttribute("aria-pressed", "true");
      slot.querySelector(".what").textContent = "Opening the camera; the first picture also loads the encoder…";
      try {
        stop = await goLive(place.querySelector("video"), {
          ask: () => liveQuestion(modality),
          onAnswer: (answer) => {
            slot.querySelector(".what").innerHTML = `<b class="fps">${Number.isFinite(answer.fps) ? answer.fps.toFixed(0) : "…"} pictures/s</b> answered; ${Math.round(answer.trip)} ms from camera to answer (encoder ${answer.ms.encoder} ms, head ${answer.ms.head} ms). None is kept.`;
            onLive(answer);
          },
          onProblem: (sentence) => { quiet(); onProblem(sentence); },
        });
      } catch (error) {
        quiet();
        refused(error, onProblem);
      }
    };
    function quiet() {
      stop?.();
      stop = null;
      slot.querySelector(".live").setAttribute("aria-pressed", "false");
      onLive(null);
    }
    slot.quiet = () => stop && quiet();

    slot.querySelector(".where").onclick = () => where(slot, onProblem);

    async function take(file, name) {
      onProblem("");
      if (file.size > LARGEST) {
        return onProblem(`'${name}' has ${(file.size / 1e6).toFixed(0)} MB and at most 20 are taken; scale it down and try again.`);
      }
      const what = slot.querySelector(".what");
      const before = what.textContent;
      slot.classList.add("busy");
      what.textContent = "Reading the image (the first one also loads the encoder)…";
      try {
        const answer = await sendImage(file, name);
        sent.set(answer.ref, { ...answer, name });
        onRef(modality, answer.ref);
      } catch (error) {
        what.textContent = before;
        refused(error, onProblem);
      } finally {
        slot.classList.remove("busy");
      }
    }
  }

  /** Show what is in both places now. */
  return function show(refs, sprite, pairs, describe) {
    for (const slot of box.children) {
      const { modality } = slot.dataset;
      const ref = refs[modality];
      if (slot.querySelector(".live").getAttribute("aria-pressed") === "true") continue;
      slot.querySelector(".picture").classList.remove("seen");
      slot.querySelector(".picture").innerHTML = picture(modality, ref, sprite, pairs);
      slot.querySelector(".what").textContent = ref ? describe(ref) : "nothing here: the head answers from the other one alone";
      slot.querySelector(".clear").disabled = !ref;
      slot.querySelector(".where").disabled = !ref || ref.startsWith("row:");
    }
  };
}

function picture(modality, ref, sprite, pairs) {
  if (!ref) return "<span>Drop or paste an image</span>";
  const [kind, name] = [ref.slice(0, ref.indexOf(":")), ref.slice(ref.indexOf(":") + 1)];
  const label = NAMES[modality][0];
  if (kind === "row") return thumbnail(sprite, +name + (modality === "tac" ? pairs : 0), 150, label);
  if (kind === "example") {
    const path = name.split("/").map(encodeURIComponent).join("/");
    return `<img src="${address(`example/${path}/${modality}`)}" alt="${label} of ${escaped(name)}">`;
  }
  const known = sent.get(ref);
  return known ? `<img src="${known.preview}" alt="${label}: ${escaped(known.name)}">` : "<span>sent earlier</span>";
}
