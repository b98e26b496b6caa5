/** Load a head or a set of one's own, for this visitor alone. */

import { ask, attempt, Refusal, sendPart } from "../shared/api.js";
import { held, own } from "../shared/held.js";

const HEAD = ["weights.safetensors", "settings.json", "metrics.json", "familiarity.safetensors", "profile.safetensors"];

/** Connect the form in `box`. @param {Found} box */
export function loading(box) {
  if (held) {
    box.querySelector("summary").textContent = "More with Python";
    const more = "It brings labels and teaching, many pairs, profiles, Live, Where?, and heads and sets of your own.";
    box.querySelector("div").textContent = `${held.alone} ${more}`;
    return;
  }
  const [button, back, note] = box.querySelectorAll(".go, .back, [role=status]");
  back.hidden = !own;
  back.onclick = () => leave(null);
  button.onclick = async () => {
    button.disabled = true;
    await attempt(async () => {
      /** @type {Record<string, string>} */
      const parts = {};
      for (const [name, file] of chosen(box.querySelector(".head").files, box.querySelector(".set").files)) {
        note.textContent = `Sending ${name} (${(file.size / 1e6).toFixed(1)} MB)…`;
        parts[name] = (await sendPart(name, file)).part;
      }
      note.textContent = "Checking…";
      leave((await ask("load", { parts, compare: box.querySelector(".second").checked })).set);
    }, note);
    button.disabled = false;
  };
}

/** The files by their names on the server. @param {File[]} folder @param {File[]} set @returns {Map<string, File>} */
function chosen(folder, set) {
  const files = new Map();
  for (const file of folder) if (HEAD.includes(file.name)) files.set(file.name, file);
  if (folder.length && !files.has("settings.json"))
    throw new Refusal(
      "That folder has no settings.json, so it is not a head. Choose the folder that `omnivat train` wrote.",
    );
  for (const file of set) {
    const ending = [".thumbnails.webp", ".thumbnails.json", ".safetensors"].find((end) => file.name.endsWith(end));
    if (ending) files.set(`embeddings${ending}`, file);
  }
  if (!files.size) throw new Refusal("Choose the folder of a head, an embeddings file, or both.");
  return files;
}

/** Open the page on another set, without the pins and filters of the old one. @param {string | null} set */
function leave(set) {
  const address = new URL(location.href);
  address.search = set ? `?set=${encodeURIComponent(set)}` : "";
  location.assign(address);
}
