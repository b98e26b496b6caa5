/** Train here: choose settings, train, follow the epochs, use the head. */

import { ask, attempt, isForgotten, json, made } from "../shared/api.js";
import { fit, loaded } from "../shared/facts.js";
import { remedyHtml } from "../shared/headless.js";
import { provenance } from "../shared/provenance.js";
import { save } from "../shared/save.js";
import { OWN_MODE } from "../shared/tables.js";
import { define } from "../shared/terms.js";
import { fill, html, put, row, table } from "../shared/text.js";
import { onClick, tell } from "../shared/view.js";
import { charts } from "./lines.js";
import { chosen, compared, formHtml, keep, kept, mapAt, result, standing, visitor } from "./plan.js";
import { RunMap } from "./run-map.js";
import { active, FIRST, next } from "./state.js";

const ALONE = html`<b>Train a head on this domain.</b> The set has no other, so accuracy away from home stays unknown.`;
const LOOK = 400; // milliseconds between two requests for progress
const HEAD = ["Settings", "p", "accuracy, unseen", "modality gap", "domain gap"];
const USE = html`<button class="main use">Open it in Explore</button><button class="save">Download the head</button><span class="hint">It is loaded for this visit only.</span>`;

/** @param {Found} root */
export async function start(root) {
  /** @param {string} selector @returns {Found} */
  const $ = (selector) => root.querySelector(selector);
  const [unfit, facts] = await Promise.all([fit().catch(() => null), loaded().catch(() => null)]);
  const offers = await attempt(
    () => json("trainings"),
    (/** @type {string} */ sentence) => tell($(".problem"), sentence, true),
  );
  if (!offers) {
    if (unfit?.problem) {
      put($(".headless"), remedyHtml(unfit));
      $(".headless").hidden = false;
    }
    $(".bench").hidden = $(".explain").hidden = true; // nothing there works without the choices
    return;
  }
  put($(".choices"), formHtml(offers));
  if (facts?.embeddings.domains?.length === 1) put($(".task"), ALONE);
  define($(".choices"));
  define($(".explain"));
  await trains($, before(facts, unfit));
}

/** What the charts show before a run: the visitor's last one, or how the loaded head was trained.
 * @param {Facts | null} facts @param {Fit | null} unfit @returns {Before | null} */
function before(facts, unfit) {
  const last = kept();
  if (last?.epochs) {
    const { epochs, question, started } = last;
    return { title: `Your last run: ${started.words}`, epochs, question, classes: started.classes.length };
  }
  const epochs = facts?.head.epochs ?? [];
  if (!facts || !epochs.length) return null;
  const title = `How ${unfit?.problem ? "a head for another set" : "the loaded head"} was trained; yours adds accuracy, gaps and a map`;
  const bare = epochs.map((one, i) => ({ ...one, epoch: i + 1, measures: {}, map: null }));
  return { title, epochs: bare, classes: facts.head.classes.length };
}

/** The tab: events in, the state drawn. @param {(selector: string) => Found} $ @param {Before | null} first */
async function trains($, first) {
  let state = { ...FIRST, before: first };
  const map = new RunMap($(".map-of-run"));
  /** @param {TrainEvent} event */
  const send = (event) => {
    state = next(state, event);
    draw($, map, state);
  };
  /** @param {string} problem */
  const onProblem = (problem) => send({ kind: "refused", problem });

  /** Request new epochs until the training has ended. @param {Started} started @param {Settings} question */
  async function follow(started, question) {
    send({ kind: "started", started, question });
    for (;;) {
      send({ kind: "news", run: started.run, reply: await news(/** @type {Run} */ (state.run)) });
      if (state.run?.started !== started || !active(state.run)) break;
      await new Promise((resolve) => setTimeout(resolve, LOOK));
    }
    if (state.run?.started !== started || state.run.standing.state !== "done") return;
    keep({ started, question, epochs: state.run.epochs.map((epoch) => ({ ...epoch, map: null })) });
  }

  $(".choices").onsubmit = (/** @type {Found} */ event) => {
    event.preventDefault();
    const question = chosen(new FormData(event.target));
    send({ kind: "asked" });
    attempt(async () => {
      const started = await ask("train", { ...question, visitor: visitor() });
      keep({ started, question });
      await follow(started, question);
    }, onProblem);
  };
  const run = () => ({ run: state.run?.started.run });
  $(".stop").onclick = () => attempt(() => ask("training/cancel", run()), onProblem);
  $(".scrubber input").oninput = (/** @type {Found} */ { target }) => send({ kind: "looked", at: +target.value });
  onClick($(".actions"), {
    // its own frames; the other modes are other heads
    ".use": () => location.assign(`?${new URLSearchParams({ set: `${state.run?.standing.set}`, mode: OWN_MODE })}`),
    ".save": () => attempt(async () => save("trained-head.zip", await made("save/trained", run())), onProblem),
  });

  draw($, map, state);
  // continue to show a training that was started before the page was reloaded, or in another tab
  const last = kept();
  const there =
    last &&
    (await attempt(
      () => ask("training", { run: last.started.run, since: 0 }),
      () => {},
    ));
  if (there) await attempt(() => follow(last.started, last.question), onProblem);
}

/** The state of a training, and its new epochs. If the server has lost it, it has failed.
 * @param {Run} run @returns {Promise<Replies["training"]>} */
async function news({ started, epochs, standing }) {
  try {
    return await ask("training", { run: started.run, since: epochs.length });
  } catch (error) {
    if (!isForgotten(error)) throw error;
    return { ...standing, state: "failed", problem: `${error instanceof Error && error.message}`, epochs: [] };
  }
}

/** Where the accuracies of a run come from. @param {string} head @param {Settings} question */
const whence = (head, { width, source }) =>
  provenance({ head: `${head} (D\u00a0=\u00a0${width})`, source, pairs: "mean of the unseen domains, test pairs" });

/** @param {(selector: string) => Found} $ @param {RunMap} map @param {TrainState} state */
function draw($, map, { run, before, at, earlier, busy, problem }) {
  tell($(".problem"), problem, true);
  $(".go").disabled = busy;
  $(".stop").hidden = $("progress").hidden = !active(run);
  $(".bench").classList.toggle("has-run", Boolean(run?.epochs.length));
  $(".preview").hidden = Boolean(run) || !before;
  if (before && !run) {
    const { title, epochs, classes, question } = before;
    $(".preview h3").textContent = title;
    if (question) fill($(".from"), whence("your last run’s head", question));
    drawCharts($(".preview .charts"), epochs, classes, { at: epochs.length, total: epochs.length }, !question);
  }
  if (!run) return;
  const { total } = run.started;
  const done = run.epochs.length;
  $(".status").textContent = standing(run);
  fill($(".from"), whence("this run’s head", run.question));
  $("progress").value = done / total;
  $(".actions").hidden = !run.standing.set;
  fill($(".actions"), run.standing.set ? USE : html``);
  $(".scrubber").hidden = done < 2;
  const slider = $(".scrubber input");
  slider.max = Math.max(1, done);
  slider.value = at;
  $(".scrubber output").textContent = `${at} of ${total}`;
  if (done) drawCharts($(".both .charts"), run.epochs, run.started.classes.length, { at: Math.max(1, at), total });
  map.show(run.started, mapAt(run.epochs, at));
  $(".earlier").hidden = !earlier.length;
  if (earlier.length) fill($(".earlier"), earlierHtml(earlier));
}

/** Draw charts at the width of their column. @param {Found} box @param {Epoch[]} epochs @param {number} classes
 * @param {{at: number, total: number}} frame */
function drawCharts(box, epochs, classes, frame, bare = false) {
  if (!box.firstElementChild) put(box, html`<figure></figure>`);
  const wide = box.firstElementChild.clientWidth || undefined; // 0 in a tab that is not open
  put(box, charts(epochs, classes, { ...frame, wide }, bare));
}

/** The runs of this visit. @param {Run[]} runs */
const earlierHtml = (runs) =>
  html`<h3>Trained in this visit</h3>${table(
    "Heads trained in this visit",
    HEAD,
    runs.map((run) => row(run.started.words, result(run))),
  )}<p class="hint">Each over the same pairs as above.</p><p class="difference">${compared(runs)}</p>`;
