"""Trainings that visitors start: one at a time, with a queue; results epoch by epoch."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from threading import Lock
from time import monotonic
from typing import TYPE_CHECKING, Any

from app.shared.jobs import Job
from app.shared.messages import BusyError
from app.shared.pair_input import thinned
from app.shared.resources import Resources
from app.shared.state import VISITOR, ForgottenError, Question, Recent, Reply
from app.shared.visitor_sets import VisitorSets
from app.train.plan import in_words, plan_from
from omnivat.kit.errors import DataError
from omnivat.kit.progress import CHECK, Step

if TYPE_CHECKING:
    import numpy as np

    from omnivat.training import TrainingPlan

    Array = np.ndarray[Any, Any]

MOST_RUNS = 12  # that run or wait
KEPT_RUNS = 48  # whose results are kept
ABANDONED_S = 150.0  # without a request for its state; a hidden tab sends one each minute
PRIORITY = 1  # after the first stops of a map, before the rest
DEADLINE_S = 600.0
MEASURE_EVERY = 4  # epochs; each measurement runs the whole set through the head
MAP_PAIRS = 2000  # pairs on the map; a larger set is thinned evenly
LONGEST_VISITOR = 40


@dataclass(eq=False)
class Run:
    """One training: its plan and its results so far."""

    plan: "TrainingPlan"
    words: str  # its settings
    visitor: tuple[str, str]  # address, and name
    job: Job[None] = field(init=False)
    epochs: list[Reply] = field(default_factory=list)
    places: "Array" = field(init=False)  # of the newest map, (2N, 2)
    loaded: str = ""  # name of the visitor set with the finished head
    looked: float = field(default_factory=monotonic)  # when its visitor last requested its state

    @property
    def active(self) -> bool:
        """Whether it waits or runs."""
        return not self.job.future.done()

    def require_visitor(self) -> None:
        """Cancel the training of a visitor who has left, so that the next one starts."""
        if monotonic() - self.looked > ABANDONED_S:
            self.job.cancel()
            self.job.check()

    def take(self, record: Reply, places: "Array | None") -> None:
        """Store the record of one epoch, and its map if there is one; report it."""
        self.epochs.append(record)
        if places is not None:
            self.places = places
        self.require_visitor()
        total, epoch = self.plan.training.epochs, record["epoch"]
        self.job.report(Step(done=epoch, total=total, text=f"epoch {epoch}"))

    def map(self) -> "tuple[Array, Array, Array]":
        """Return places (2n, 2) of some pairs at the last epoch, VIS then TAC, their domains and
        classes.
        """
        embeddings = self.plan.embeddings
        rows = thinned(len(embeddings), MAP_PAIRS)
        places: Array = self.places.reshape(2, -1, 2)[:, rows].reshape(-1, 2)
        return places, embeddings.domain[rows], embeddings.label[rows]


class Trainings:
    """The trainings that visitors started, newest kept."""

    def __init__(self, sets: VisitorSets) -> None:
        self.sets = sets
        self._runs: Recent[Run] = Recent(KEPT_RUNS)
        self._lock = Lock()

    def start(self, resources: Resources, question: Question, name: str) -> str:
        """Queue a training on a set for the visitor called `name`; return the name of the run.

        A training is cancelled if its state is not requested for ABANDONED_S seconds. Raises
        DataError for invalid settings, or if the visitor already has one in the queue; BusyError if
        the queue is full, or half of it is of their address.
        """
        if not 0 < len(name) <= LONGEST_VISITOR:
            raise DataError("visitor has to be a short name that the page made; reload the page.")
        visitor = address, _ = VISITOR.get(), name
        plan = plan_from(question, resources.embeddings())
        run = Run(plan=plan, words=in_words(plan, question), visitor=visitor)
        key = os.urandom(12).hex()
        with self._lock:
            active = [other.visitor for other in self._runs.values() if other.active]
            if visitor in active:
                raise DataError(
                    "Your training before this one still runs or waits; cancel it first."
                )
            own = sum(place == address for place, _ in active)
            if len(active) >= MOST_RUNS or own >= MOST_RUNS // 2:
                full = len(active) >= MOST_RUNS
                what = f"{MOST_RUNS} trainings" if full else f"{own} trainings of your address"
                raise BusyError(f"{what} run or wait here already; try again in a few minutes.")
            run.job = self.sets.shared.jobs.start(
                lambda job: self._work(job, run, resources.owner),
                lane="long",
                visitor=address,
                priority=PRIORITY,
                deadline_s=DEADLINE_S,
            )
            self._runs.keep(key, run)
        return key

    def named(self, name: str) -> Run:
        """Return a run, whose visitor is there. Raises ForgottenError if it is not kept."""
        run = self._runs.get(name[:64])
        if run is None:
            raise ForgottenError("The server no longer has this training; start it again.")
        run.looked = monotonic()
        return run

    def finished(self, names: Sequence[str]) -> list[Run]:
        """Return those of these runs that are kept and have a head."""
        runs = (self._runs.get(name[:64]) for name in names)
        return [run for run in runs if run and run.loaded]

    def _work(self, job: Job[None], run: Run, beside: str) -> None:
        """Train the head of a run, measure it and load it beside the set."""
        from omnivat.maps.epochs import reporter
        from omnivat.measure.known import scored
        from omnivat.training import Watch, trained_head

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
        head = trained_head(run.plan, watch=Watch(on_epoch=shown))
        run.loaded = self.sets.adopt(scored(head, run.plan.embeddings), beside=beside)
