/** Load a head or a set of one's own, for this visitor alone. */

import { ask, Refusal, refused, sendPart } from "../shared/api.js";
import { held } from "../shared/held.js";

const HEAD = ["weights.safetensors", "settings.json", "metrics.json", "familiarity.safetensors", "profile.safetensors"];
const inUse = () => new URLSearchParams(location.search).get("set");

/** Connect the form in `box`. */
export function loading(box) {
  if (held) {
    box.querySelector("div").textContent = held.alone;
    return;
  }
  const note = box.querySelector("[role=status]");
  const button = box.querySelector(".go");
  const back = box.querySelector(".back");
  back.hidden = !inUse();
  back.onclick = () => leave(null);
  button.onclick = async () => {
    button.disabled = true;
    try {
      const files = chosen(box);
      const parts = {};
      for (const [name, file] of Object.entries(files)) {
        note.textContent = `Sending ${name} (${(file.size / 1e6).toFixed(1)} MB)…`;
        parts[name] = (await sendPart(name, file)).part;
      }
      note.textContent = "Checking…";
      const { set } = await ask("load", { parts, compare: box.querySelector(".second").checked });
      leave(set);
    } catch (error) {
      refused(error, note);
    } finally {
      button.disabled = false;
    }
  };
}

/** The files by their names on the server. */
function chosen(box) {
  const files = {};
  for (const file of box.querySelector(".head").files) if (HEAD.includes(file.name)) files[file.name] = file;
  if (box.querySelector(".head").files.length && !files["settings.json"]) {
    throw new Refusal(
      "That folder has no settings.json, so it is not a head. Choose the folder that `omnivat train` wrote.",
    );
  }
  for (const file of box.querySelector(".set").files) {
    const ending = [".thumbnails.webp", ".thumbnails.json", ".safetensors"].find((end) => file.name.endsWith(end));
    if (ending) files[`embeddings${ending}`] = file;
  }
  if (!Object.keys(files).length) throw new Refusal("Choose the folder of a head, an embeddings file, or both.");
  return files;
}

/** Open the page on another set, without the pins and filters of the old one. */
function leave(set) {
  const address = new URL(location.href);
  address.search = "";
  if (set) address.searchParams.set("set", set);
  location.assign(address);
}
