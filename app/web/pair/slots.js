/** The two image slots: choose, drop, paste, camera; each file is uploaded once. */

import { address, refused, sendImage } from "../shared/api.js";
import { thumbnail } from "../shared/card.js";
import { escaped } from "../shared/text.js";
import { LiveSwitch } from "./live.js";
import { sent } from "./sent.js";
import { snapshot } from "./webcam.js";
import { where } from "./where.js";

const NAMES = { vis: ["Photo", "VIS: the surface"], tac: ["Touch", "TAC: the sensor’s image"] };
const LARGEST = 20e6;
const READING = "Reading the image (the first one also loads the encoder)…";

/** Fill the box with both slots. Returns show(refs, sprite, pairs, describe). */
export function slots(box, on) {
  box.innerHTML = Object.entries(NAMES).map(slotHtml).join("");
  const all = [...box.children].map((element) => new Slot(element, on));
  return (refs, sprite, pairs, describe) => {
    for (const slot of all) slot.show(refs[slot.modality], sprite, pairs, describe);
  };
}

const slotHtml = ([key, [name, what]]) => `
  <div class="slot panel" data-modality="${key}" tabindex="0" aria-label="${name}: ${what}. Drop or paste an image here.">
    <h3><span class="sign ${key}"></span>${name} <small>${what}</small></h3>
    <div class="picture"><span>Drop or paste an image</span></div>
    <div class="row"><label class="choose">Choose file<input type="file" accept="image/*,.tif,.tiff,.webp,.png,.jpg" aria-label="Choose a ${name.toLowerCase()}"></label>
    <button type="button" class="camera" title="Take one picture">Camera</button><button type="button" class="live" aria-pressed="false" title="Predict from the camera, picture after picture">Live</button><button type="button" class="where" title="Hide one part after the other and see how the prediction changes">Where?</button><button type="button" class="clear" aria-label="Remove the ${name.toLowerCase()}">Remove</button></div>
    <p class="what">&nbsp;</p>
  </div>`;

class Slot {
  constructor(element, on) {
    this.element = element;
    this.on = on;
    this.modality = element.dataset.modality;
    this.live = new LiveSwitch(this.$(".live"), {
      place: () => this.$(".picture"),
      tell: (text) => (this.$(".what").textContent = text),
      question: () => on.liveQuestion(this.modality),
      onAnswer: on.onLive,
      onProblem: on.onProblem,
    });
    element.quiet = () => this.live.on && this.live.off();
    this.takeFiles();
    this.$(".clear").onclick = () => on.onRef(this.modality, null);
    this.$(".camera").onclick = () => this.photograph();
    this.$(".where").onclick = () => where(element, on.lessons(), on.onProblem);
  }

  $(selector) {
    return this.element.querySelector(selector);
  }

  takeFiles() {
    const { element } = this;
    const input = this.$("input");
    input.onchange = async () => {
      if (input.files[0]) await this.take(input.files[0], input.files[0].name);
      input.value = "";
    };
    element.ondragover = (event) => {
      event.preventDefault();
      element.classList.add("over");
    };
    element.ondragleave = () => element.classList.remove("over");
    element.ondrop = (event) => {
      event.preventDefault();
      element.classList.remove("over");
      const file = event.dataTransfer.files[0];
      if (file) this.take(file, file.name);
    };
    element.onpaste = (event) => {
      const file = [...event.clipboardData.files][0];
      if (file) this.take(file, file.name || "the pasted image");
    };
  }

  async photograph() {
    try {
      const picture = await snapshot(this.$(".picture"));
      if (picture) await this.take(picture, "the camera’s image");
    } catch (error) {
      refused(error, this.on.onProblem);
    }
  }

  async take(file, name) {
    const { onProblem, onRef } = this.on;
    onProblem("");
    if (file.size > LARGEST) {
      return onProblem(
        `'${name}' has ${(file.size / 1e6).toFixed(0)} MB; the limit is 20 MB. Scale it down and try again.`,
      );
    }
    const what = this.$(".what");
    const before = what.textContent;
    this.element.classList.add("busy");
    what.textContent = READING;
    try {
      const answer = await sendImage(file, name);
      sent.set(answer.ref, { ...answer, name });
      onRef(this.modality, answer.ref);
    } catch (error) {
      what.textContent = before;
      refused(error, onProblem);
    } finally {
      this.element.classList.remove("busy");
    }
  }

  /** Show the current images; a running camera stays. */
  show(ref, sprite, pairs, describe) {
    if (this.live.on) return;
    this.$(".picture").classList.remove("seen");
    this.$(".picture").innerHTML = picture(this.modality, ref, sprite, pairs);
    this.$(".what").textContent = ref ? describe(ref) : "Empty: only the other image is used.";
    this.$(".clear").disabled = !ref;
    this.$(".where").disabled = !ref || ref.startsWith("row:");
  }
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
  return known
    ? `<img src="${known.preview}" alt="${label}: ${escaped(known.name)}">`
    : "<span>sent earlier</span>";
}
