/** Load a head, an embeddings file or both from this browser, for this visitor only. */

import { ask, Refusal, refused, sendPart } from "../shared/api.js";
import { held } from "../shared/held.js";

const HEAD = ["weights.safetensors", "settings.json", "metrics.json", "familiarity.safetensors", "profile.safetensors"];
const inUse = () => new URLSearchParams(location.search).get("set");

export function loading(box) {
  if (held) {
    box.textContent = held.alone;
    return;
  }
  box.innerHTML = `<p>For you alone, until the server restarts.</p>
    <div class="pickers"><label>Head (folder) <input type="file" class="head" webkitdirectory multiple></label>
    <label>Embeddings, thumbnails <input type="file" class="set" multiple accept=".safetensors,.webp,.json"></label></div>
    <div class="row"><label><input type="checkbox" class="beside"> Add for comparison</label></div>
    <div class="row"><button type="button" class="main go">Load</button>${inUse() ? '<button type="button" class="back">Back to the server’s own head and set</button>' : ""}<span class="hint" role="status"></span></div>`;
  const note = box.querySelector("[role=status]");
  const button = box.querySelector(".go");
  const back = box.querySelector(".back");
  if (back) back.onclick = () => leave(null);
  button.onclick = async () => {
    button.disabled = true;
    try {
      const files = chosen(box);
      const parts = {};
      for (const [name, file] of Object.entries(files)) {
        note.textContent = `Sending ${name} (${(file.size / 1e6).toFixed(1)} MB)…`;
        parts[name] = await sendPart(name, file);
      }
      note.textContent = "Checking…";
      const { set } = await ask("load", { parts, compare: box.querySelector(".beside").checked });
      leave(set);
    } catch (error) {
      refused(error, (sentence) => {
        note.textContent = sentence;
      });
    } finally {
      button.disabled = false;
    }
  };
}

/** The files by their names on the server. */
function chosen(box) {
  const found = {};
  for (const file of box.querySelector(".head").files) if (HEAD.includes(file.name)) found[file.name] = file;
  if (box.querySelector(".head").files.length && !found["settings.json"]) {
    throw new Refusal(
      "That folder has no settings.json, so it is not a head. Choose the folder that `omnivat train` wrote.",
    );
  }
  for (const file of box.querySelector(".set").files) {
    const ending = [".thumbnails.webp", ".thumbnails.json", ".safetensors"].find((end) => file.name.endsWith(end));
    if (ending) found[`embeddings${ending}`] = file;
  }
  if (!Object.keys(found).length) throw new Refusal("Choose the folder of a head, an embeddings file, or both.");
  return found;
}

/** Open the page on another set, without the pins and filters of the old one. */
function leave(set) {
  const address = new URL(location.href);
  address.search = "";
  if (set) address.searchParams.set("set", set);
  location.assign(address);
}
