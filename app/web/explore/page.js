/** Explore's chapters: each opens with its set, its frames and its view. */

import { attempt, refused } from "../shared/api.js";
import { fit, pairNames, unseen } from "../shared/facts.js";
import { whenFine } from "../shared/frames.js";
import { setOf } from "../shared/sets.js";
import { openAt, openChapter, state } from "../shared/store.js";
import { OWN_MODE } from "../shared/tables.js";
import { Board } from "./board.js";
import { chapterNamed, startOf } from "./chapters.js";
import { dataOf } from "./library.js";
import { Modes } from "./modes.js";
import { showSets } from "./panels.js";
import { Threads } from "./threads.js";
import { OneTouch } from "./touch.js";
import { wire, wireBoard } from "./wiring.js";

export class Page {
  /** `say` shows the sentence of a Refusal, `telling` the server's progress; null for none. */
  constructor($, { sets, twins }, { say, telling }) {
    this.$ = $;
    this.sets = sets;
    this.first = !sets.some(({ shown }) => shown) ? "analyse" : twins ? "touch" : "order";
    this.say = say;
    this.telling = telling;
    this.chapter = ""; // the one on screen; none while its set loads
    this.modes = new Modes($(".modes"), { onFrames: (frames) => this.board?.replace(frames), say });
    /** @type {any} */
    this.data = null;
    /** @type {Board | null} */
    this.board = null; // made with the first set
    this.touch = new OneTouch($(".touch"));
    this.threads = new Threads($, !sets.some(({ shown }) => shown));
    showSets($(".sets"), sets);
    for (const name of ["touch", "where"]) $(`.chapters [data-chapter=${name}]`).hidden = !twins; // as in a saved page
    wire(this);
  }

  /** Open the chapter in the address: its set, its frames, its view. */
  async enter() {
    if (!state.chapter) return openChapter(this.first);
    const { chapter } = state;
    this.chapter = "";
    this.layOut(chapter);
    const late = () => state.chapter !== chapter;
    return attempt(async () => {
      if (chapter === "touch") {
        await this.touch.open();
        return late() || this.opened(chapter);
      }
      if (chapter === "where") {
        await this.threads.open();
        if (late()) return;
        this.telling(null);
        this.$(".explore").classList.add("ready");
      }
      const set = setOf(chapter, this.sets);
      const data = await dataOf(set, (step) => !this.chapter && this.telling(step));
      if (late()) return;
      const board = this.boardOf(data);
      if (board.scene.set !== set) board.scene.load(data);
      this.data = data;
      const frames = await this.modes.open(data);
      if (late() || !frames) return;
      this.opened(chapter);
      this.start(board, frames);
      this.learnAll(board, data);
      if (data.coarse) this.refine(board, data);
    }, this.say);
  }

  opened(chapter) {
    this.telling(null);
    this.chapter = chapter;
    this.$(".explore").classList.add("ready");
  }

  /** The parts, made once. */
  boardOf(data) {
    if (!this.board) wireBoard(this, (this.board = new Board(this.$, data, this.threads)));
    return this.board;
  }

  /** Show the parts of a chapter. */
  layOut(chapter) {
    const root = this.$(".explore");
    root.dataset.chapter = chapter;
    for (const part of root.querySelectorAll("[data-for]"))
      part.hidden = !part.dataset.for.split(" ").includes(chapter);
    for (const button of root.querySelectorAll(".chapters [data-chapter]")) {
      button.setAttribute("aria-current", button.dataset.chapter === chapter ? "page" : "false");
      if (button.dataset.chapter === chapter) button.parentElement.scrollLeft = button.offsetLeft - 40; // on a phone
    }
    const lesson = chapterNamed(chapter);
    if (!lesson) return;
    this.$(".next").textContent = lesson.next;
    this.$(".next").dataset.chapter = lesson.to;
  }

  start(board, frames) {
    const { set, own } = board.scene;
    if (state.p === null) openAt(startOf(state.chapter, frames, own));
    if (state.pin !== null && !(state.pin < frames.pairs)) state.pin = null;
    board.start(frames, this.sets.find(({ name }) => state.chapter === "order" && set && name !== set)?.curve);
  }

  learnAll(board, data) {
    const learn = (name) => (fact) => {
      data.facts[name] = fact;
      if (this.data === data && this.chapter) board.learned();
    };
    if (data.facts.unseen && data.facts.pairs) return board.learned();
    pairNames(data.set).then(learn("pairs"), () => {});
    if (data.own.headless) return fit(data.set).then(learn("fit"), () => {});
    unseen(data.set).then(learn("unseen"), (error) => refused(error, this.$(".strangers .hint")));
    return undefined;
  }

  /** Finer frames of the head itself are computed: wait for them. */
  async refine(board, data) {
    data.coarse = false;
    const own = await whenFine((step) => this.telling(step));
    this.telling(null);
    const shown = board.scene.own === board.scene.frames;
    data.own = own;
    data.frames.set(OWN_MODE, own);
    if (this.data !== data) return;
    board.scene.own = own;
    if (shown && this.chapter) board.replace(own);
  }
}
