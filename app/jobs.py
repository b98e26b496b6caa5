"""Long work: a queue with positions, and a state for each job.

A job is a function of its `Job`. At each `omnivat.kit.progress.checkpoint` and each
`job.report(step)` it stops if its visitor is gone or its time is over, and waits for jobs of higher
priority.
"""

import logging
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as ended
from dataclasses import dataclass, field, replace
from itertools import count
from threading import Condition
from time import monotonic, sleep
from typing import Any, Generic, Literal, TypeVar

from app.limits import AGE_S, GIVE_WAY_S, SLOTS, WAITING_JOBS
from app.messages import UNEXPECTED, BusyError, CancelledError, UnexpectedError
from app.state import VISITOR
from omnivat.kit.errors import OmniVatError
from omnivat.kit.progress import CHECK, Pace, Step

log = logging.getLogger(__name__)
T = TypeVar("T")
LOOK_S = 0.005
MOST_THREADS = 1000  # of running and paused jobs; idle ones wait for the next job
State = Literal["waiting", "running", "done", "failed", "cancelled"]


class JobStopped(BaseException):
    """Raised in a cancelled job; not an Exception, so that no handler catches it."""


@dataclass(eq=False)
class Job(Generic[T]):
    """One job: its state and its result."""

    jobs: "Jobs"
    work: "Callable[[Job[T]], T]"
    lane: str
    owner: str
    visitor: str
    priority: int
    left_s: float | None  # seconds of running that are left; None: no limit
    number: int
    future: Future[T] = field(default_factory=Future)
    cancelled: bool = False
    queued: float = 0.0  # when it last started waiting
    since: float = 0.0  # when it last started running
    begun: bool = False  # it has a thread, running or paused
    step: Step | None = None
    state: State = "waiting"
    pace: Pace = field(default_factory=Pace)

    def __post_init__(self) -> None:
        self.future.set_running_or_notify_cancel()  # only `cancel` below cancels

    def report(self, step: Step) -> None:
        """Report progress; raises the errors of `check`."""
        self.step = replace(step, left=self.pace.left(step))
        self.check()

    def check(self) -> None:
        """Continue, or wait for a higher priority. Raises JobStopped or, out of time, BusyError."""
        self.jobs.pause(self)

    def give_way(self) -> None:
        """Wait while requests run or wait, at most GIVE_WAY_S; for work in small steps."""
        self.jobs.give_way(self)

    def go_on_at(self, priority: int) -> None:
        """Continue at another priority; raises the errors of `check`."""
        self.priority = priority
        self.check()

    def cancel(self) -> None:
        """Stop the work: at once if it waits, at its next `check` if it runs."""
        self.jobs.cancel(self)

    @property
    def place(self) -> int:
        """The position in the queue, from 1; 0 if it does not wait."""
        return self.jobs.place(self)

    @property
    def problem(self) -> str:
        """The reason of a failure, one sentence; else ""."""
        return str((self.future.done() and self.future.exception()) or "")

    def wait(self, timeout_s: float | None = None) -> T:
        """Return the result of the work; raises its OmniVatError, or TimeoutError."""
        return self.future.result(timeout_s)

    def run(self) -> None:
        """Run the work and store its result; called in the job's own thread."""
        self.state = "running"
        VISITOR.set(self.visitor)
        CHECK.set(self.check)
        try:
            value = self.work(self)
        except JobStopped:
            self.end("cancelled", CancelledError("This work was cancelled."))
        except OmniVatError as error:
            log.info("a job was refused: %s", error)
            self.end("failed", error.with_traceback(None))  # it would keep what the work held
        except BaseException:  # for any error: a caller waits for the end
            log.exception("a job failed")
            self.end("failed", UnexpectedError(UNEXPECTED))
        else:
            self.state = "done"
            self.future.set_result(value)

    def end(self, state: State, error: OmniVatError) -> None:
        """End the job without a value."""
        self.state = state
        self.future.set_exception(error)


class _Lane:
    """Jobs of one kind: at most `slots` running, and the waiting ones.

    Higher priority goes first; after `age_s` of waiting a job counts as of the next one. One of
    several slots is for jobs of priority 0, so that a rush of uploads does not hold up drags. Among
    equals, paused jobs go first, then the oldest.
    """

    def __init__(self, slots: int, age_s: float) -> None:
        self.slots, self.age_s = slots, age_s
        self.running: set[Job[Any]] = set()
        self.waiting: list[Job[Any]] = []

    def add(self, job: Job[Any]) -> None:
        job.queued = monotonic()
        self.waiting.append(job)

    def rank(self, job: Job[Any]) -> tuple[int, bool, int]:
        """Return the key by which waiting jobs are sorted."""
        level = max(0, job.priority - int((monotonic() - job.queued) / self.age_s))
        return level, not job.begun, job.number

    def next(self) -> Job[Any] | None:
        """Move the first waiting job to the running ones; None if there is no slot for any."""
        if len(self.running) >= self.slots:
            return None
        later = sum(job.priority > 0 for job in self.running)
        ready = [job for job in self.waiting if not job.priority or later < max(1, self.slots - 1)]
        if not ready:
            return None
        job = min(ready, key=self.rank)
        self.waiting.remove(job)
        self.running.add(job)
        return job


class Jobs:
    """Runs jobs in lanes; lanes are independent of one another."""

    def __init__(self, slots: Mapping[str, int] = SLOTS) -> None:
        self._lanes = {name: _Lane(number, AGE_S[name]) for name, number in slots.items()}
        self._changed = Condition()  # a paused job was woken or stopped
        self._threads = ThreadPoolExecutor(MOST_THREADS, "job")
        self._numbers = count()
        self._closed = False

    def start(
        self,
        work: Callable[[Job[T]], T],
        *,
        lane: str,
        owner: str = "",
        visitor: str = "",
        priority: int = 0,
        deadline_s: float | None = None,
    ) -> Job[T]:
        """Put work in the queue of a lane; return the job.

        owner       owner of the job, for `cancel_owner`
        visitor     whose pictures and heads the job finds; see `app.requests.visitor_of`
        priority    smaller numbers run first; a running job yields at its next check
        deadline_s  seconds of running, without waiting; None: no limit

        Raises BusyError if too many jobs are waiting.
        """
        line = self._lanes[lane]
        with self._changed:
            if self._closed:
                raise BusyError("The server is stopping; start it again.")
            if len(line.waiting) >= WAITING_JOBS:
                raise BusyError("Too much is waiting here already; try again in a minute.")
            job = Job(self, work, lane, owner, visitor, priority, deadline_s, next(self._numbers))
            line.add(job)
            self._let_in(line)
        return job

    def pause(self, job: Job[Any]) -> None:
        """Stop the job if it is cancelled or out of time; wait for jobs of higher priority."""
        line = self._lanes[job.lane]
        with self._changed:
            spent = monotonic() - job.since
            if job.left_s is not None and spent > job.left_s:
                raise BusyError(
                    "This took longer than allowed and was stopped; try something smaller."
                )
            better = any(one.priority < job.priority for one in line.waiting)
            if better and job in line.running and not job.cancelled:
                job.left_s = None if job.left_s is None else job.left_s - spent
                line.running.discard(job)
                line.add(job)
                self._let_in(line)
                self._changed.wait_for(lambda: job in line.running or job.cancelled)
        if job.cancelled:
            raise JobStopped

    def give_way(self, job: Job[Any]) -> None:
        """Wait while the quick lane has jobs, at most GIVE_WAY_S; the time is not the job's own.

        It looks every LOOK_S: a wait for `_changed` would wake it twice for each request.
        """
        began, quick = monotonic(), self._lanes["quick"]
        while (
            (quick.running or quick.waiting)
            and not job.cancelled
            and monotonic() - began < GIVE_WAY_S
        ):
            sleep(LOOK_S)
        job.since += monotonic() - began

    def cancel(self, job: Job[Any]) -> None:
        """Stop one job."""
        line = self._lanes[job.lane]
        with self._changed:
            job.cancelled = True
            unborn = job in line.waiting and not job.begun
            if job in line.waiting:
                line.waiting.remove(job)
            self._changed.notify_all()
        if unborn:
            job.end("cancelled", CancelledError("This work was cancelled."))

    def cancel_owner(self, owner: str) -> None:
        """Stop every job of an owner."""
        with self._changed:
            theirs = [job for job in self._all() if job.owner == owner]
        for job in theirs:
            self.cancel(job)

    def close(self, wait_s: float = 2.0) -> None:
        """Stop all jobs, accept no more, and wait briefly for threads to end."""
        with self._changed:
            self._closed = True
            everything = self._all()
        for job in everything:
            self.cancel(job)
        ended([job.future for job in everything], wait_s)
        self._threads.shutdown(wait=False)

    def place(self, job: Job[Any]) -> int:
        """Return the job's position in its queue, from 1; 0 if it is not waiting."""
        with self._changed:
            line = self._lanes[job.lane]
            return sorted(line.waiting, key=line.rank).index(job) + 1 if job in line.waiting else 0

    def _all(self) -> list[Job[Any]]:
        return [job for line in self._lanes.values() for job in (*line.running, *line.waiting)]

    def _let_in(self, line: _Lane) -> None:
        """Start or wake the jobs that may run now; the caller holds the lock."""
        while job := line.next():
            job.since = monotonic()
            if job.begun:
                self._changed.notify_all()
                continue
            job.begun = True
            try:
                self._threads.submit(self._run, job)
            except RuntimeError:  # the system has no more threads
                line.running.discard(job)
                job.end("failed", BusyError("The server has no thread left; try again later."))

    def _run(self, job: Job[Any]) -> None:
        try:
            if not job.future.done():
                job.run()
        finally:
            line = self._lanes[job.lane]
            with self._changed:
                line.running.discard(job)
                self._let_in(line)
