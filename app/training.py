"""Train here: one training at a time, reported epoch by epoch, with a queue."""

import base64
import os
from dataclasses import dataclass, field
from threading import Lock
from time import monotonic
from typing import TYPE_CHECKING, Any

from app.jobs import Job
from app.messages import BusyError
from app.resources import Resources
from app.saving import head_zip
from app.state import VISITOR, ForgottenError, Question, Recent, Reply
from app.training_plan import in_words, plan_from, thinned
from app.visitor_sets import VisitorSets
from omnivat.kit.errors import DataError
from omnivat.kit.progress import CHECK, Step

if TYPE_CHECKING:
    import numpy as np

    from omnivat.head.checkpoint import Head
    from omnivat.training.from_pairs import TrainingPlan

MOST_RUNS = 12  # that run or wait
KEPT_RUNS = 48  # whose results are kept
ABANDONED_S = 150.0  # without a request for its state; a hidden tab sends one each minute
PRIORITY = 1  # after the first stops of a map, before the rest
DEADLINE_S = 600.0
MEASURE_EVERY = 4  # epochs; each measurement runs the whole set through the head
MAP_PAIRS = 2000  # pairs on the map in training; a larger set is thinned evenly
REACH = 1.5  # maps show unit rows, so coordinates are within it
LONGEST_VISITOR = 40


@dataclass(eq=False)
class Run:
    """One training: its plan and its results so far."""

    plan: "TrainingPlan"
    rows: "np.ndarray[Any, Any]"  # pairs on the maps
    job: Job[None] = field(init=False)
    epochs: list[Reply] = field(default_factory=list)
    head: "Head | None" = None
    visitor: tuple[str, str] = ("", "")  # address, and name
    loaded: str = ""  # name of the visitor set with the finished head
    looked: float = field(default_factory=monotonic)  # when its visitor last requested its state

    def require_visitor(self) -> None:
        """Cancel the training of a visitor who has left, so that the next one starts."""
        if monotonic() - self.looked > ABANDONED_S:
            self.job.cancel()
            self.job.check()

    def take(self, report: Any) -> None:
        """Store the results of one epoch, losses, measures and a map; report it."""
        self.epochs.append(
            {
                "epoch": int(report.epoch),
                "order": round(float(report.order), 4),
                **{name: _number(value) for name, value in report.losses.items()},
                "measures": {name: _number(value) for name, value in report.measures.items()},
                "map": None if report.map is None else coded_map(report.map, self.rows),
            }
        )
        self.require_visitor()
        self.job.report(
            Step(
                done=int(report.epoch),
                total=self.plan.training.epochs,
                text=f"epoch {report.epoch}",
            )
        )


class Trainings:
    """The trainings that visitors started, newest kept."""

    def __init__(self, sets: VisitorSets) -> None:
        self._sets = sets
        self._runs: Recent[Run] = Recent(KEPT_RUNS)
        self._lock = Lock()

    def start(self, resources: Resources, question: Question) -> Reply:
        """Queue a training on a set; return its name and the pairs on its maps.

        question  {"visitor": name, "source", "width", …}: see `app.training_plan`

        A training is cancelled if its state is not requested for ABANDONED_S seconds. Raises
        DataError for invalid settings, or if the visitor already has one in the queue; BusyError if
        the queue is full, or half of it is of their address.
        """
        address = VISITOR.get()
        if (
            not isinstance(name := question.get("visitor"), str)
            or not 0 < len(name) <= LONGEST_VISITOR
        ):
            raise DataError("visitor has to be a short name that the page made; reload the page.")
        visitor = address, name
        embeddings = resources.embeddings()
        plan = plan_from(question, embeddings)
        run = Run(plan=plan, rows=thinned(len(embeddings), MAP_PAIRS), visitor=visitor)
        key = os.urandom(12).hex()
        with self._lock:
            active = [one.visitor for one in self._runs.values() if not one.job.future.done()]
            if visitor in active:
                raise DataError(
                    "Your training before this one still runs or waits; cancel it first."
                )
            own = sum(one[0] == address for one in active)
            if len(active) >= MOST_RUNS or own >= MOST_RUNS // 2:
                full = len(active) >= MOST_RUNS
                what = f"{MOST_RUNS} trainings" if full else f"{own} trainings of your address"
                raise BusyError(f"{what} run or wait here already; try again in a few minutes.")
            run.job = self._sets.shared.jobs.start(
                lambda job: self._work(job, run, resources.owner),
                lane="long",
                visitor=address,
                priority=PRIORITY,
                deadline_s=DEADLINE_S,
            )
            self._runs.keep(key, run)
        return {
            "run": key,
            "total": plan.training.epochs,
            "source": plan.source,
            "words": in_words(plan, question),
            "left_out": plan.left_out,  # without a class
            "reach": REACH,
            "domains": list(embeddings.header.domains),
            "classes": list(embeddings.header.classes),
            "domain": embeddings.domain[run.rows].tolist(),
            "label": embeddings.label[run.rows].tolist(),
        }

    def state(self, question: Question) -> Reply:
        """Return the state of a training, and its epochs from number `since` on."""
        run = self._run(question)
        since = question.get("since", 0)
        if type(since) is not int or since < 0:
            raise DataError(f"since is {since!r:.20}; give the number of epochs you have.")
        run.looked = monotonic()
        job, step = run.job, run.job.step
        return {
            "state": job.state,
            "place": job.place,
            "problem": job.problem if job.state == "failed" else "",
            "text": step.text if step else "",
            "left": step.left if step else "",
            "epochs": run.epochs[since:],
            "set": run.loaded,
        }

    def cancel(self, question: Question) -> Reply:
        """Stop a training."""
        self._run(question).job.cancel()
        return self.state(question)

    def saved(self, question: Question) -> bytes:
        """Return a zip of a finished head. Raises DataError before it is finished."""
        run = self._run(question)
        if run.head is None:
            raise DataError("This training has not finished, so there is no head to save.")
        return head_zip(run.head, "trained-head")

    def _run(self, question: Question) -> Run:
        run = self._runs.get(str(question.get("run", ""))[:64])
        if run is None:
            raise ForgottenError("The server no longer has this training; start it again.")
        return run

    def _work(self, job: Job[None], run: Run, beside: str) -> None:
        from omnivat.training import Watch
        from omnivat.training.from_pairs import reporter, trained_head

        def check() -> None:
            job.give_way()
            job.check()

        CHECK.set(check)
        run.job = job
        run.require_visitor()
        training = run.plan.training
        first = "searching p" if training.order_search else "loading"
        job.report(Step(done=0, total=training.epochs, text=first))
        shown = reporter(run.plan, run.take, every=MEASURE_EVERY)
        run.head = trained_head(run.plan, watch=Watch(on_epoch=shown))
        run.loaded = self._sets.adopt(run.head, beside=beside)


def coded_map(flat: "np.ndarray[Any, Any]", rows: "np.ndarray[Any, Any]") -> str:
    """Return the positions of some pairs, VIS then TAC, as base64 of u16 within ±REACH."""
    import numpy as np

    pairs = len(flat) // 2
    chosen = flat[np.concatenate([rows, rows + pairs])]
    scaled = np.rint((np.clip(chosen, -REACH, REACH) + REACH) / (2 * REACH) * 65535)
    return base64.b64encode(scaled.astype("<u2").tobytes()).decode()


def _number(value: Any) -> float | None:
    """Return a number for JSON; None for NaN."""
    number = float(value)
    return round(number, 5) if number == number else None
