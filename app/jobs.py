"""Work that takes a while: a queue with places, a state for each job, and an end for every job.

A job is a function that takes its `Job` and calls `job.report(step)` or `job.check()` now and then.
That is where it ends when its visitor is gone or its time is over, and where it waits while a job
of a better priority goes first. Whatever is raised ends in a sentence and a state.
"""

import logging
from bisect import insort
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import count
from threading import Condition, Thread
from time import monotonic
from typing import Any, Generic, Literal, TypeVar

from app.limits import OWN_JOBS, SLOTS, WAITING_JOBS
from app.messages import UNEXPECTED
from omnivat.errors import OmniVatError
from omnivat.progress import Step

log = logging.getLogger(__name__)
T = TypeVar("T")
State = Literal["waiting", "running", "done", "failed", "cancelled"]


class JobStopped(BaseException):
    """Raised inside a cancelled job; no handler of errors on the way takes it for one."""


class CancelledError(OmniVatError):
    """The job was cancelled before it ended."""

    status = 499


class BusyError(OmniVatError):
    """Too much is waiting already, or the work took too long."""

    status = 503


class UnexpectedError(OmniVatError):
    """The job failed in a way that nobody thought of; the log has the traceback."""

    status = 500


@dataclass(frozen=True, slots=True, kw_only=True)
class Status:
    """What can be said of a job now."""

    state: State
    place: int  # in the queue, from 1; 0 where it does not wait
    step: Step | None  # how far it is
    problem: str  # why it failed, in one sentence

    @property
    def ended(self) -> bool:
        """Whether nothing more will happen."""
        return self.state in ("done", "failed", "cancelled")


class Job(Generic[T]):
    """One piece of work: where it stands, and its end."""

    def __init__(
        self,
        jobs: "Jobs",
        work: "Callable[[Job[T]], T]",
        *,
        lane: str,
        owner: str,
        priority: int,
        deadline_s: float | None,
        number: int,
    ) -> None:
        self.owner, self.priority, self.lane = owner, priority, lane
        self.future: Future[T] = Future()
        self.future.set_running_or_notify_cancel()  # only `cancel` below cancels
        self.rank = (priority, number)
        self.cancelled = False
        self.left_s = deadline_s
        self.since = 0.0  # when it was last let in
        self.thread: Thread | None = None
        self._jobs, self._work = jobs, work
        self._step: Step | None = None
        self._state: State = "waiting"

    def report(self, step: Step) -> None:
        """Say how far the work is; raises as `check` does."""
        self._step = step
        self.check()

    def check(self) -> None:
        """Go on, wait for a better job, or stop: raises JobStopped or, out of time, BusyError."""
        self._jobs.pause(self)

    def go_on_at(self, priority: int) -> None:
        """Go on at another priority; raises as `check` does."""
        self.priority, self.rank = priority, (priority, self.rank[1])
        self.check()

    def cancel(self) -> None:
        """Stop the work: at once where it waits, at its next `check` where it runs."""
        self._jobs.cancel(self)

    def status(self) -> Status:
        """Return where the job stands."""
        error = self.future.exception() if self.future.done() else None
        return Status(
            state=self._state,
            place=self._jobs.place(self),
            step=self._step,
            problem=str(error) if error else "",
        )

    def wait(self, timeout_s: float | None = None) -> T:
        """Return what the work returned; raises its OmniVatError, or TimeoutError."""
        return self.future.result(timeout_s)

    def run(self) -> None:
        """Do the work and keep its end; called in the job's own thread."""
        self._state = "running"
        try:
            value = self._work(self)
        except JobStopped:
            self.end("cancelled", CancelledError("This work was cancelled."))
        except OmniVatError as error:
            log.info("a job was refused: %s", error)
            self.end("failed", error)
        except BaseException:  # whatever it is, somebody waits for the end
            log.exception("a job failed")
            self.end("failed", UnexpectedError(UNEXPECTED))
        else:
            self._state = "done"
            self.future.set_result(value)

    def end(self, state: State, error: OmniVatError) -> None:
        """End the job without a value."""
        self._state = state
        self.future.set_exception(error)


class _Lane:
    """Jobs of one kind: those that run, at most `slots`, and those that wait, best first."""

    def __init__(self, slots: int) -> None:
        self.slots = slots
        self.running: set[Job[Any]] = set()
        self.waiting: list[Job[Any]] = []

    def add(self, job: Job[Any]) -> None:
        insort(self.waiting, job, key=lambda one: one.rank)

    def next(self) -> Job[Any] | None:
        """Move the best waiting job among those that run; None where none may."""
        if len(self.running) >= self.slots or not self.waiting:
            return None
        job = self.waiting.pop(0)
        self.running.add(job)
        return job


class Jobs:
    """Runs jobs, in lanes that do not wait for one another."""

    def __init__(self, slots: Mapping[str, int] = SLOTS) -> None:
        self._lanes = {name: _Lane(number) for name, number in slots.items()}
        self._changed = Condition()
        self._numbers = count()
        self._closed = False

    def start(
        self,
        work: Callable[[Job[T]], T],
        *,
        lane: str,
        owner: str = "",
        priority: int = 0,
        deadline_s: float | None = None,
    ) -> Job[T]:
        """Put work in the queue of a lane; return the job.

        owner       whose work it is: `cancel_owner` ends it; one owner has OWN_JOBS at most
        priority    the smaller goes first; a running job gives way at its next check
        deadline_s  seconds of running, not of waiting; none where None

        Raises BusyError when too much waits already.
        """
        line = self._lanes[lane]
        with self._changed:
            self._require_room(line, owner)
            job: Job[T] = Job(
                self,
                work,
                lane=lane,
                owner=owner,
                priority=priority,
                deadline_s=deadline_s,
                number=next(self._numbers),
            )
            line.add(job)
            self._let_in(line)
        return job

    def pause(self, job: Job[Any]) -> None:
        """Stop the job where it was cancelled or is late; let better jobs go first."""
        line = self._lanes[job.lane]
        with self._changed:
            self._require_time(job)
            better = line.waiting and line.waiting[0].priority < job.priority
            if better and job in line.running and not job.cancelled:
                self._spend(job)
                line.running.discard(job)
                line.add(job)
                self._let_in(line)
                self._changed.wait_for(lambda: job in line.running or job.cancelled)
        if job.cancelled:
            raise JobStopped

    def cancel(self, job: Job[Any]) -> None:
        """Stop one job."""
        line = self._lanes[job.lane]
        with self._changed:
            job.cancelled = True
            unborn = job in line.waiting and job.thread is None
            if job in line.waiting:
                line.waiting.remove(job)
            self._changed.notify_all()
        if unborn:
            job.end("cancelled", CancelledError("This work was cancelled."))

    def cancel_owner(self, owner: str) -> None:
        """Stop every job of an owner who is gone."""
        with self._changed:
            theirs = [job for job in self._all() if job.owner == owner]
        for job in theirs:
            self.cancel(job)

    def close(self, wait_s: float = 2.0) -> None:
        """Stop everything, take nothing more, and wait a moment for threads to end."""
        with self._changed:
            self._closed = True
            everything = self._all()
        for job in everything:
            self.cancel(job)
        until = monotonic() + wait_s
        for job in everything:
            if job.thread is not None:
                job.thread.join(max(0.0, until - monotonic()))

    def place(self, job: Job[Any]) -> int:
        """Return the job's place in its queue, from 1; 0 where it does not wait."""
        with self._changed:
            waiting = self._lanes[job.lane].waiting
            return waiting.index(job) + 1 if job in waiting else 0

    def _all(self) -> list[Job[Any]]:
        return [job for line in self._lanes.values() for job in (*line.running, *line.waiting)]

    def _require_room(self, line: _Lane, owner: str) -> None:
        if self._closed:
            raise BusyError("The server is stopping; start it again.")
        own = sum(job.owner == owner for job in (*line.running, *line.waiting)) if owner else 0
        if len(line.waiting) >= WAITING_JOBS or own >= OWN_JOBS:
            raise BusyError("Too much is waiting here already; try again in a minute.")

    def _require_time(self, job: Job[Any]) -> None:
        if job.left_s is not None and monotonic() - job.since > job.left_s:
            raise BusyError("This took longer than allowed and was stopped; try something smaller.")

    def _spend(self, job: Job[Any]) -> None:
        if job.left_s is not None:
            job.left_s -= monotonic() - job.since

    def _let_in(self, line: _Lane) -> None:
        """Start or wake what may run now; the lock is held."""
        while job := line.next():
            job.since = monotonic()
            if job.thread is None:
                self._begin(line, job)
        self._changed.notify_all()

    def _begin(self, line: _Lane, job: Job[Any]) -> None:
        job.thread = Thread(target=self._run, args=(job,), name="job", daemon=True)
        try:
            job.thread.start()
        except RuntimeError:  # the system gives no more threads
            job.thread = None
            line.running.discard(job)
            job.end("failed", BusyError("The server has no thread left; try again in a minute."))

    def _run(self, job: Job[Any]) -> None:
        try:
            job.run()
        finally:
            line = self._lanes[job.lane]
            with self._changed:
                line.running.discard(job)
                self._let_in(line)
