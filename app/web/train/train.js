/** Train here: choose settings, train, follow the epochs, use the head. */

import { ask, attempt, isForgotten, made, refused } from "../shared/api.js";
import { fit, loaded } from "../shared/facts.js";
import { remedyHtml } from "../shared/headless.js";
import { provenance } from "../shared/provenance.js";
import { save } from "../shared/save.js";
import { OWN_MODE } from "../shared/tables.js";
import { define } from "../shared/terms.js";
import { escaped, row, table } from "../shared/text.js";
import { onClick, tell, View } from "../shared/view.js";
import { charts } from "./lines.js";
import { chosen, compared, formHtml, inWords, keep, kept, mapAt, result, standing, visitor } from "./plan.js";
import { RunMap } from "./run-map.js";

const ALONE = "<b>Train a head on this domain.</b> The set has no other, so accuracy away from home stays unknown.";
const LOOK = 400; // milliseconds between two requests for progress

/** Where the accuracies of a run come from. */
const whence = (head, { width, source }) =>
  provenance({ head: `${head} (D\u00a0=\u00a0${width})`, source, pairs: "mean of the unseen domains, test pairs" });

export async function start(root) {
  const problem = root.querySelector(".problem");
  const [unfit, facts] = await Promise.all([fit().catch(() => null), loaded().catch(() => null)]);
  try {
    new TrainTab(root, await ask("trainings", {}), unfit?.problem);
    if (facts?.embeddings.domains?.length === 1) root.querySelector(".task").innerHTML = ALONE;
  } catch (error) {
    refused(error, problem);
    problem.hidden = false;
    if (unfit?.problem)
      problem.insertAdjacentHTML("afterend", `<div class="panel headless">${remedyHtml(unfit)}</div>`);
    root.querySelector(".bench").hidden = root.querySelector(".explain").hidden = true; // nothing there works without the choices
  }
}

class TrainTab extends View {
  /** `unfit` says why the loaded head does not fit the set, if so. */
  constructor(root, offers, unfit) {
    super(root);
    this.unfit = unfit;
    /** @type {any} */
    this.run = null; // {name, question, total, epochs, state}
    this.earlier = [];
    this.at = 0; // the epoch shown; the newest while it follows
    this.follows = true;
    this.map = new RunMap(this.$(".map-of-run"));
    this.$(".choices").innerHTML = formHtml(offers);
    define(this.$(".choices"));
    define(this.$(".explain"));
    this.wire();
    this.show();
    this.resume();
  }

  wire() {
    this.$(".choices").onsubmit = (event) => {
      event.preventDefault();
      this.begin(chosen(new FormData(event.target)));
    };
    this.$(".stop").onclick = () => this.cancel();
    this.$(".scrubber input").oninput = (event) => {
      this.at = +event.target.value;
      this.follows = this.at === this.run.epochs.length;
      this.show();
    };
    onClick(this.$(".actions"), { ".use": () => this.use(), ".save": () => this.save() });
  }

  problem = (sentence) => tell(this.$(".problem"), sentence, true);

  async begin(question) {
    this.problem("");
    this.$(".go").disabled = true;
    try {
      const started = await ask("train", { ...question, visitor: visitor() });
      keep({ started, question });
      await this.watch(started, question);
    } catch (error) {
      refused(error, this.problem);
    } finally {
      this.$(".go").disabled = false;
    }
  }

  /** Continue to show a training that was started before the page was reloaded, or in another tab. */
  async resume() {
    const earlier = kept();
    if (!earlier) return this.preview(null);
    await attempt(
      async () => {
        await ask("training", { run: earlier.started.run, since: 0 }); // refused if the server no longer has it
        await this.watch(earlier.started, earlier.question);
      },
      () => this.preview(earlier),
    );
  }

  /** Before a run: the curves of the visitor's last one, or of the loaded head. */
  async preview(earlier) {
    const { head } = earlier?.epochs ? { head: null } : await loaded().catch(() => ({ head: null }));
    const own = (head?.metrics?.epochs ?? []).map((one, i) => ({ ...one, epoch: i + 1, measures: {} }));
    const epochs = earlier?.epochs ?? own;
    if (this.run || !epochs.length) return;
    const title = earlier?.epochs
      ? `Your last run: ${inWords(earlier.question)}`
      : `How ${this.unfit ? "a head for another set" : "the loaded head"} was trained; yours adds accuracy, gaps and a map`;
    this.$(".preview h3").textContent = title;
    this.$(".preview").hidden = false;
    this.$(".from").innerHTML = earlier?.epochs ? whence("your last run’s head", earlier.question) : "";
    const box = this.$(".preview .charts");
    const columns = getComputedStyle(box).gridTemplateColumns.split(" ").length;
    box.innerHTML = charts(
      epochs,
      epochs.length,
      epochs.length,
      earlier?.started.classes.length ?? head?.classes.length,
      Math.max(0, box.clientWidth / columns - 14) || undefined,
      !earlier,
    );
  }

  async watch(started, question) {
    this.run = {
      name: started.run,
      question,
      total: started.total,
      leftOut: started.left_out,
      classes: started.classes.length,
      epochs: [],
      state: { state: "waiting", place: 0, text: "", left: "", problem: "", set: "" },
    };
    this.follows = true;
    this.at = 0;
    this.map.begin(started);
    this.show();
    await this.follow(this.run);
  }

  /** Request new epochs until the training has ended. */
  async follow(run) {
    while (this.run === run) {
      const { epochs, ...state } = await this.news(run);
      run.epochs.push(...epochs);
      run.state = state;
      if (this.follows) this.at = run.epochs.length;
      this.show();
      if (["done", "failed", "cancelled"].includes(state.state)) break;
      await new Promise((resolve) => setTimeout(resolve, LOOK));
    }
    if (run.state.state === "done") this.remember(run);
  }

  /** The state of a training, and its new epochs. If the server has lost it, it has failed. */
  async news(run) {
    try {
      return await ask("training", { run: run.name, since: run.epochs.length });
    } catch (error) {
      if (!isForgotten(error)) throw error;
      return { ...run.state, state: "failed", problem: `${error instanceof Error && error.message}`, epochs: [] };
    }
  }

  async cancel() {
    await attempt(async () => {
      await ask("training/cancel", { run: this.run.name });
    }, this.problem);
  }

  show() {
    const { run } = this;
    const active = run && ["waiting", "running"].includes(run.state.state);
    this.$(".stop").hidden = !active;
    this.$(".bench").classList.toggle("has-run", Boolean(run?.epochs.length));
    if (!run) return;
    const done = run.epochs.length;
    this.$(".preview").hidden = true;
    this.$(".status").textContent = standing(run.state, { epochs: done, total: run.total, leftOut: run.leftOut });
    this.$(".from").innerHTML = whence("this run’s head", run.question);
    this.$(".bar-of-epochs").hidden = !active;
    this.$(".bar-of-epochs i").style.width = `${(100 * done) / run.total}%`;
    this.showActions();
    this.$(".scrubber").hidden = done < 2;
    const slider = this.$(".scrubber input");
    slider.max = Math.max(1, done);
    slider.value = this.at;
    this.$(".scrubber output").textContent = `${this.at} of ${run.total}`;
    if (!done) return;
    this.$(".both .charts").innerHTML = charts(
      run.epochs,
      run.total,
      Math.max(1, this.at),
      run.classes,
      this.$(".both .charts svg")?.getBoundingClientRect().width || undefined,
    );
    this.map.show(mapAt(run.epochs, this.at)?.map);
  }

  showActions() {
    const made = this.run.state.set;
    this.$(".actions").hidden = !made;
    if (made && this.$(".actions").dataset.set !== made) {
      this.$(".actions").dataset.set = made;
      this.$(".actions").innerHTML =
        '<button type="button" class="main use">Open it in Explore</button><button type="button" class="save">Download the head</button><span class="hint">It is loaded for this visit only.</span>';
    }
  }

  remember(run) {
    keep({ ...kept(), epochs: run.epochs.map(({ map, ...one }) => one) });
    this.earlier.push({ words: inWords(run.question), ...result(run.epochs) });
    const rows = this.earlier.map((one) =>
      row(escaped(one.words), [one.order?.toFixed(3) ?? "–", one.unseen, one.modality, one.domain]),
    );
    const head = ["Settings", "p", "accuracy, unseen", "modality gap", "domain gap"];
    this.$(".earlier").hidden = false;
    this.$(".earlier").innerHTML =
      `<h3>Trained in this visit</h3>${table("Heads trained in this visit", head, rows)}<p class="hint">Each over the same pairs as above.</p><p class="difference"></p>`;
    if (this.earlier.length < 2) return;
    this.$(".difference").textContent = compared(this.earlier);
  }

  use() {
    const address = new URL(location.href);
    address.search = "";
    address.searchParams.set("set", this.run.state.set);
    address.searchParams.set("mode", OWN_MODE); // its own frames; the other modes are other heads
    location.assign(address);
  }

  async save() {
    await attempt(async () => {
      save("trained-head.zip", await made("save/trained", { run: this.run.name }));
    }, this.problem);
  }
}
