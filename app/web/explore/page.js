/** Explore's chapters: each opens with its set, its frames and its view. */

import { attempt, refused } from "../shared/api.js";
import { fit, pairNames, unseen } from "../shared/facts.js";
import { whenFine } from "../shared/frames.js";
import { setOf } from "../shared/sets.js";
import { openAt, openChapter, state } from "../shared/store.js";
import { Board } from "./board.js";
import { chapterNamed, startOf } from "./chapters.js";
import { centredFrames, dataOf } from "./library.js";
import { Modes } from "./modes.js";
import { showSets } from "./panels.js";
import { wire } from "./wiring.js";

export class Page {
  /** `say` shows the sentence of a Refusal, `telling` the server's progress; null for none. */
  constructor($, { sets }, { say, telling }) {
    this.$ = $;
    this.sets = sets;
    this.first = sets.some(({ shown }) => shown) ? "order" : "analyse";
    this.say = say;
    this.telling = telling;
    this.chapter = ""; // the one on screen; none while its set loads
    this.modes = new Modes($(".modes"), { onFrames: (frames) => this.board?.replace(frames), say });
    /** @type {any} */
    this.data = null;
    /** @type {Board | null} */
    this.board = null; // made with the first set
    showSets($(".sets"), sets);
  }

  /** Open the chapter in the address: its set, its frames, its view. */
  async enter() {
    if (!state.chapter) return openChapter(this.first);
    const { chapter } = state;
    this.chapter = "";
    this.layOut(chapter);
    const late = () => state.chapter !== chapter;
    return attempt(async () => {
      const set = setOf(chapter, this.sets);
      const data = await dataOf(set, (step) => !this.chapter && this.telling(step));
      if (late()) return;
      const board = this.boardOf(data);
      if (board.scene.set !== set) board.scene.load(data);
      this.data = data;
      const frames = await (chapter === "failure" ? (data.centred ?? data.own) : this.modes.open(data));
      if (late() || !frames) return;
      this.telling(null);
      this.chapter = chapter;
      this.start(board, frames);
      this.learnAll(board, data);
      if (chapter === "failure" && !data.centred) this.centre(board, data);
      if (data.coarse) this.refine(board, data);
    }, this.say);
  }

  /** The parts, made once. */
  boardOf(data) {
    if (!this.board) wire(this, (this.board = new Board(this.$, data)));
    return this.board;
  }

  /** Show the frames of the second chapter once they are made; a set may be too large to centre. */
  centre(board, data) {
    return attempt(
      async () => {
        const frames = await centredFrames(data);
        if (this.data === data && this.chapter === "failure") board.replace(frames);
      },
      () => {},
    );
  }

  /** Show the parts of a chapter. */
  layOut(chapter) {
    const root = this.$(".explore");
    root.dataset.chapter = chapter;
    for (const part of root.querySelectorAll("[data-for]"))
      part.hidden = !part.dataset.for.split(" ").includes(chapter);
    for (const button of root.querySelectorAll(".chapters [data-chapter]"))
      button.setAttribute("aria-current", button.dataset.chapter === chapter ? "page" : "false");
    const lesson = chapterNamed(chapter);
    if (lesson) this.$(".next").textContent = lesson.next;
  }

  start(board, frames) {
    const { set, own } = board.scene;
    if (state.p === null) openAt(startOf(state.chapter, frames, own));
    if (state.pin !== null && !(state.pin < frames.pairs)) state.pin = null;
    board.start(frames, this.sets.find(({ name }) => state.chapter === "order" && set && name !== set)?.curve);
    this.$(".explore").classList.add("ready");
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
    data.frames.set("moved", own);
    if (this.data !== data) return;
    board.scene.own = own;
    if (shown && this.chapter) board.replace(own);
  }
}
