/** The state of Train here, from one event to the next. No DOM here. */

/** @type {TrainState} */
export const FIRST = { run: null, before: null, at: 0, follows: true, earlier: [], busy: false, problem: "" };

/** @type {Standing} */
const WAITING = { state: "waiting", place: 0, text: "", left: "", problem: "", set: "" };

/** True while a run waits or trains. @param {Run | null} run */
export const active = (run) => run !== null && ["waiting", "running"].includes(run.standing.state);

/** @param {TrainState} state @param {TrainEvent} event @returns {TrainState} */
export function next(state, event) {
  const { run } = state;
  switch (event.kind) {
    case "asked":
      return { ...state, busy: true, problem: "" };
    case "refused":
      return { ...state, busy: false, problem: event.problem };
    case "started": {
      const { started, question } = event;
      return { ...state, run: { started, question, epochs: [], standing: WAITING }, at: 0, follows: true };
    }
    case "looked":
      return { ...state, at: event.at, follows: event.at === run?.epochs.length };
    case "news": {
      if (run?.started.run !== event.run) return state; // another one has begun
      const { epochs, ...standing } = event.reply;
      const now = { ...run, epochs: [...run.epochs, ...epochs], standing };
      return {
        ...state,
        run: now,
        at: state.follows ? now.epochs.length : state.at,
        busy: state.busy && active(now),
        earlier: standing.state === "done" ? [...state.earlier, now] : state.earlier,
      };
    }
  }
}
