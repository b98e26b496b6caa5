/** Where a pair is chosen: two image slots (file, drop, paste, camera), and the shelf of examples. */

import { address, attempt, refused } from "../shared/api.js";
import { thumbnail } from "../shared/card.js";
import { IMAGES, OTHER } from "../shared/images.js";
import { shelf } from "../shared/pick.js";
import { awaited } from "../shared/ready.js";
import { change } from "../shared/store.js";
import { each, escaped } from "../shared/text.js";
import { onClick, View } from "../shared/view.js";
import { chosenFiles, droppedFiles, sent, snapshot, upload } from "./own-pictures.js";
import { TERMS } from "./verdict.js";
import { where } from "./where.js";

const READING = "Reading the image (the first one also loads the encoder)…";

/** Fill the box with both slots. Returns show(refs, sprite, pairs, describe). */
export function slots(box, on) {
  box.innerHTML = each(Object.entries(TERMS), slotHtml);
  const all = [...box.children].map((element) => new Slot(element, on));
  return (refs, sprite, pairs, describe) => {
    for (const slot of all) slot.show(refs[slot.modality], refs[OTHER[slot.modality]], sprite, pairs, describe);
  };
}

const titleHtml = (key) => `<span class="sign ${key}"></span>${TERMS[key].title}`;
const slotHtml = ([key, { title: name, what }]) => `
  <div class="slot panel" data-modality="${key}" tabindex="0" aria-label="${name}: ${what}. Drop or paste an image here.">
    <h3>${titleHtml(key)}</h3>
    <div class="picture"><span>Drop or paste an image</span></div>
    <div class="row"><label class="choose">Choose file<input type="file" multiple accept="image/*,.tif,.tiff,.webp,.png,.jpg" aria-label="Choose a ${name.toLowerCase()}"></label>
    <button type="button" class="camera" title="Take one picture">Camera</button><button type="button" class="where" title="Hide one part after the other and see how the prediction changes">Where?</button><button type="button" class="clear" aria-label="Remove the ${name.toLowerCase()}">Remove</button></div>
    <p class="what">&nbsp;</p>
  </div>`;

class Slot extends View {
  constructor(element, on) {
    super(element);
    this.on = on;
    this.modality = element.dataset.modality;
    this.takeFiles();
    this.$(".clear").onclick = () => on.onRef(this.modality, null);
    this.$(".camera").onclick = () => this.photograph();
    this.$(".where").onclick = () => where(element, on.lessons(), on.onProblem);
  }

  takeFiles() {
    const { box: element } = this;
    const input = this.$("input");
    input.onchange = async () => {
      await this.takeAll(chosenFiles(input.files));
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
      event.stopPropagation();
      awaited(droppedFiles(event.dataTransfer).then((files) => this.takeAll(files)));
    };
    element.onpaste = (event) => {
      const file = [...event.clipboardData.files][0];
      if (file) this.take(file);
    };
  }

  /** One picture belongs here; several are pairs. */
  takeAll(files) {
    return files.length > 1 ? this.on.onMany(files) : files[0] && this.take(files[0].file);
  }

  async photograph() {
    await attempt(async () => {
      const picture = await snapshot(this.$(".picture"));
      if (picture) await this.take(new File([picture], "the camera’s image"));
    }, this.on.onProblem);
  }

  async take(file) {
    const { onProblem, onUpload, onBusy } = this.on;
    onProblem("");
    onBusy(1);
    const what = this.$(".what");
    const before = what.textContent;
    this.box.classList.add("busy");
    what.textContent = READING;
    try {
      onUpload(this.modality, await upload(file));
    } catch (error) {
      what.textContent = before;
      refused(error, onProblem);
    } finally {
      this.box.classList.remove("busy");
      onBusy(-1);
    }
  }

  /** Show the current images; a running camera stays. */
  show(ref, other, sprite, pairs, describe) {
    this.$("h3").innerHTML = titleHtml(this.modality);
    this.$(".picture").classList.remove("seen");
    this.$(".picture").innerHTML = picture(this.modality, ref, sprite, pairs);
    this.$(".what").textContent = ref ? describe(ref) : other ? "Empty: only the other image is used." : "Empty.";
    this.$(".clear").disabled = !ref;
    this.$(".where").disabled = !ref || ref.startsWith("row:");
  }
}

function picture(modality, ref, sprite, pairs) {
  if (!ref) return "<span>Drop or paste an image</span>";
  const [kind, name] = [ref.slice(0, ref.indexOf(":")), ref.slice(ref.indexOf(":") + 1)];
  const label = TERMS[modality].title;
  if (kind === "row") return thumbnail(sprite, +name + (modality === "tac" ? pairs : 0), 150, label);
  if (kind === "example") {
    const path = name.split("/").map(encodeURIComponent).join("/");
    return `<img src="${address(`example/${path}/${modality}`)}" alt="${label} of ${escaped(name)}">`;
  }
  const known = sent.get(ref);
  return known
    ? `<img src="${known.preview ?? URL.createObjectURL(known.file)}" alt="${label}: ${escaped(known.name)}">`
    : "<span>sent earlier</span>";
}

export class Gallery {
  constructor(box, take) {
    this.box = box;
    onClick(box, {
      "[data-ref]": ({ dataset: { ref } }) =>
        change(take.value === "both" ? { vis: ref, tac: ref } : { [take.value]: ref }),
    });
  }

  fill(examples, set) {
    const offers = shelf(examples, set.frames);
    const none = set.frames
      ? "There are no examples. Upload images, or pin a pair in Explore."
      : "The set’s pairs appear with its map, which is being computed. Your own images work meanwhile.";
    this.box.innerHTML = offers.length ? each(offers, (one) => offer(one, set)) : `<p class="hint">${none}</p>`;
  }

  mark(refs) {
    for (const button of this.box.querySelectorAll("button")) {
      button.setAttribute("aria-pressed", String(refs.includes(button.dataset.ref)));
    }
  }
}

function offer(one, set) {
  const name = escaped(`${one.truth}, ${one.domain}`);
  return `<button type="button" data-ref="${escaped(one.ref)}" title="${name}" aria-label="${name}"><span>${pictures(one, set)}</span><small>${escaped(one.truth)}</small></button>`;
}

function pictures({ path, pair }, { sprite, frames }) {
  if (path === undefined) {
    return each(["photo", "touch"], (label, i) => thumbnail(sprite, pair + i * frames.pairs, 48, label));
  }
  const coded = path.split("/").map(encodeURIComponent).join("/");
  return IMAGES.map((modality) => `<img loading="lazy" alt="" src="${address(`example/${coded}/${modality}`)}">`).join(
    "",
  );
}
