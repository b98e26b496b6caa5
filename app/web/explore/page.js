/** Explore's chapters: each opens with its set, its frames and its view. */

import { attempt, once } from "../shared/api.js";
import { choices, fit, pairNames, unseen } from "../shared/facts.js";
import { whenFine } from "../shared/frames.js";
import { setOf } from "../shared/sets.js";
import { change, openAt, openChapter } from "../shared/store.js";
import { sayWhetherSimulated, theSet } from "../shared/theset.js";
import { making, tell } from "../shared/view.js";
import * as board from "./board.js";
import { LESSONS, startOf } from "./chapters.js";
import * as gaps from "./gaps.js";
import { framesOfMode, isOtherWanted } from "./modes.js";
import { $, all, scene, send, state } from "./root.js";
import * as threads from "./threads.js";
import * as touch from "./touch.js";

const PROJECT = ["touch", "where", "order"]; // chapters that show the project's data, whatever is loaded

/** Show the sentence of a Refusal. If the address names a set, which the server may have dropped, add a link to the
 * page without it. */
export function say(/** @type {string} */ sentence) {
  tell($(".wait"), sentence, true);
  if (!new URLSearchParams(location.search).has("set")) return;
  const home = Object.assign(document.createElement("a"), { href: location.pathname });
  home.textContent = "Open the page without it.";
  $(".wait").append(" ", home);
}

/** Show the server's progress; null for none. @param {Step | null} step */
const telling = (step) => tell($(".wait"), step === null ? "" : making(step));

/** Show the mode in the address if another one is shown. */
export async function followMode() {
  const frames = isOtherWanted() && (await framesOfMode(say));
  if (frames) board.replace(frames);
}

/** Return the set of a chapter. Finer frames take the place of coarse ones later.
 * @type {(set: string, onWait: (step: Step | null) => void) => Promise<SetData>} */
const dataOf = (set, onWait) =>
  once(`data ${set}`, async () => {
    const [{ frames: own, sprite }, { modes }] = await Promise.all([theSet(onWait, set), choices(set)]);
    return { set, own, sprite, modes };
  });

/** Open the chapter in the address: its set, its frames, its view. */
export async function enter() {
  if (!state.chapter) return openChapter(scene.first);
  const { chapter } = state;
  send("arrived", { chapter: "" });
  layOut(chapter);
  $().classList.remove("ready"); // nothing of the chapter before stands below this one's name
  $(".announcement").textContent = "";
  tell($(".wait"), "Loading this chapter…");
  let problem = "";
  const late = () => state.chapter !== chapter;
  return attempt(async () => {
    const still = { touch, where: threads }[chapter]; // their pictures do not follow p
    if (still) {
      await still.open();
      if (late()) return;
      sayWhetherSimulated(scene.twins.simulated);
      return opened(chapter);
    }
    const set = chapter === "gaps" ? gaps.chosenHead().set : setOf(chapter, scene.sets);
    const data = await dataOf(set, (step) => !scene.chapter && telling(step));
    if (late()) return;
    if (scene.own !== data.own) send("loaded", data);
    board.build();
    const note = (/** @type {string} */ sentence) => (problem = sentence);
    const frames = await (chapter === "gaps" ? gaps.framesOfHead(note) : framesOfMode(note));
    if (late()) return;
    if (!frames) return say(problem);
    if (state.p === null) openAt(startOf(chapter, frames, data.own));
    if (state.pin !== null && !(state.pin < frames.pairs)) change({ pin: null });
    sayWhetherSimulated(data.own.meta.embeddings.simulated, data.own.domains);
    opened(chapter);
    board.start(frames);
    learnAll(data);
    if (data.own.coarse) refine(data);
    if (problem) say(problem); // another mode is shown than was wanted
  }, say);
}

/** @param {string} chapter */
function opened(chapter) {
  telling(null);
  send("arrived", { chapter });
  $().classList.add("ready");
}

/** Scroll the chapters to the chosen one, on a phone. */
export function bringIntoSight() {
  for (const button of all(".chapters [aria-current=page]")) button.parentElement.scrollLeft = button.offsetLeft - 40;
}

/** Show the parts of a chapter. @param {string} chapter */
function layOut(chapter) {
  $().dataset.chapter = chapter;
  for (const part of all("[data-for]")) part.hidden = !part.dataset.for.split(" ").includes(chapter);
  for (const button of all(".chapters [data-chapter]"))
    button.setAttribute("aria-current", button.dataset.chapter === chapter ? "page" : "false");
  bringIntoSight();
  $(".whose").hidden = !threads.isOwn() || !PROJECT.includes(chapter);
  const lesson = LESSONS[chapter];
  if (!lesson) return;
  $(".next").textContent = lesson.next;
  $(".next").dataset.chapter = lesson.to;
}

/** Fetch what is known of a set, and show it. @param {SetData} data */
function learnAll({ set, own }) {
  const { facts } = scene;
  /** @param {keyof SetFacts} name @param {Promise<SetFacts[keyof SetFacts]>} coming
   * @param {import("../shared/api.js").Say} say */
  const learn = async (name, coming, say = () => {}) => {
    const fact = await attempt(() => coming, say);
    if (!fact) return;
    send("learned", { set, facts: { [name]: fact } });
    if (set === scene.set && scene.chapter) board.learned();
  };
  if (facts.unseen && facts.pairs) return board.learned();
  learn("pairs", pairNames(set));
  if (own.headless) return learn("fit", fit(set));
  return learn("unseen", unseen(set), $(".strangers .hint"));
}

/** Finer frames of the head itself are computed: wait for them. @param {SetData} data */
async function refine(data) {
  const coarse = data.own;
  const own = await once(`finer frames ${data.set}`, () => whenFine(telling, { set: data.set }));
  telling(null);
  data.own = own;
  if (scene.own !== coarse) return;
  const shown = (scene.frames.whole ?? scene.frames) === coarse;
  send("arrived", { own });
  if (shown && scene.chapter) board.replace(scene.chapter === "gaps" ? gaps.atStops(own) : own);
}
