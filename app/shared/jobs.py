"""Long work: a queue with positions, and a state for each job.

A job is a function of its `Job`. At each `omnivat.kit.progress.checkpoint` and each
`job.report(step)` it stops if its visitor is gone or its time is over, and waits for jobs of higher
priority.
"""

import logging
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as ended
from dataclasses import dataclass, field, replace
from itertools import count
from math import inf
from threading import Condition
from time import monotonic, sleep
from typing import Any, Generic, Literal, TypeVar

from app.shared.limits import GIVE_WAY_S, LONGEST_WAIT_S, SLOTS, WAITING_JOBS
from app.shared.memory import TRIM
from app.shared.messages import UNEXPECTED, BusyError, CancelledError, UnexpectedError
from app.shared.state import VISITOR
from omnivat.kit.errors import OmniVatError
from omnivat.kit.progress import CHECK, Pace, Step

log = logging.getLogger(__name__)
T = TypeVar("T")
LOOK_S = 0.005
MOST_THREADS = 1000  # of running and paused jobs; idle ones wait for the next job
State = Literal["waiting", "running", "done", "failed", "cancelled"]


class JobStopped(BaseException):
    """Raised in a cancelled job; not an Exception, so that no handler catches it."""


class Lane:
    """Jobs of one kind: at most `slots` running, and the waiting ones.

    The visitor with the fewest jobs before goes first, whatever the priority of another's second
    job; the server's own work has no visitor and waits for none. Then smaller priorities go first;
    among equals, paused jobs, then the oldest. A lane of several slots has short requests. So that
    a rush of uploads does not hold up drags, a job of priority 0 has one more slot while all others
    run jobs of larger priorities, and so has any job while all others run those of another visitor.
    So that drags do not hold up an upload for ever, it has priority 0 in the queue once it is
    LONGEST_WAIT_S old.
    """

    def __init__(self, slots: int, threads: ThreadPoolExecutor) -> None:
        self._slots, self._threads = slots, threads
        self.running: set[Job[Any]] = set()
        self.waiting: list[Job[Any]] = []
        self.changed = Condition()  # a paused job was woken or stopped

    def in_order(self, paused: "Job[Any] | None" = None) -> "list[Job[Any]]":
        """Return the waiting jobs, the next one first; as if a running one were `paused`."""
        before = Counter(job.visitor for job in self.running - {paused})
        turn = {}
        waiting = [*self.waiting, *([paused] if paused else [])]
        late = monotonic() - LONGEST_WAIT_S if self._slots > 1 else 0.0
        rank = {
            job: (min(job.priority, 0) if job.arrived < late else job.priority, not job.begun)
            for job in waiting
        }
        for job in sorted(waiting, key=lambda job: (rank[job], job.number)):
            turn[job] = before[job.visitor] if job.visitor else 0
            before[job.visitor] += 1
        return sorted(waiting, key=lambda job: (turn[job], rank[job], job.number))

    def let_in(self) -> None:
        """Start or wake the jobs that may run now; the caller holds the lock."""
        for job in self.in_order():
            first = job.priority <= 0 < min((other.priority for other in self.running), default=0)
            visitors = {other.visitor for other in self.running}
            guest = len(visitors) == 1 and job.visitor not in visitors
            more = self._slots > 1 and (first or guest)
            if len(self.running) >= self._slots + more:
                continue
            self.waiting.remove(job)
            self.running.add(job)
            job.since = monotonic()
            if not job.begun:
                job.begun = True
                self._threads.submit(job.run)
        self.changed.notify_all()


@dataclass(eq=False)
class Job(Generic[T]):
    """One job: its state and its result."""

    work: "Callable[[Job[T]], T]"
    lane: Lane
    requests: Lane  # to which it gives way
    owner: str
    visitor: str
    priority: int
    left_s: float  # seconds of running that are left
    number: int
    future: Future[T] = field(default_factory=Future)
    cancelled: bool = False
    arrived: float = field(default_factory=monotonic)
    since: float = 0.0  # when it last started running, or ended without a result
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
        with self.lane.changed:
            spent = monotonic() - self.since
            if spent > self.left_s:
                raise BusyError(
                    "This took longer than allowed and was stopped; try something smaller."
                )
            better = any(other.priority < self.priority for other in self.lane.waiting)
            if better and not self.cancelled and self.lane.in_order(self)[0] is not self:
                self.left_s -= spent
                self.lane.running.remove(self)
                self.lane.waiting.append(self)
                self.lane.let_in()
                self.lane.changed.wait_for(lambda: self in self.lane.running or self.cancelled)
        if self.cancelled:
            raise JobStopped

    def give_way(self) -> None:
        """Wait while requests run or wait, at most GIVE_WAY_S, which is not the job's own time; for
        work in small steps.

        It looks every LOOK_S: a wait for `changed` would wake it twice for each request.
        """
        began, requests = monotonic(), self.requests
        while (
            (requests.running or requests.waiting)
            and not self.cancelled
            and monotonic() - began < GIVE_WAY_S
        ):
            sleep(LOOK_S)
        self.since += monotonic() - began

    def cancel(self) -> None:
        """Stop the work: at once if it waits, at its next `check` if it runs."""
        with self.lane.changed:
            self.cancelled = True
            if self in self.lane.waiting:
                self.lane.waiting.remove(self)
                if not self.begun:
                    self._stopped()
            self.lane.changed.notify_all()

    @property
    def place(self) -> int:
        """The position in the queue, from 1; 0 if it does not wait."""
        waiting = self.lane.in_order()
        return waiting.index(self) + 1 if self in waiting else 0

    @property
    def problem(self) -> str:
        """The reason of a failure, one sentence; else ""."""
        return str((self.future.done() and self.future.exception()) or "")

    def run(self) -> None:
        """Run the work and store its result; called in the job's own thread."""
        self.state = "running"
        VISITOR.set(self.visitor)
        CHECK.set(self.check)
        try:
            value = self.work(self)
        except JobStopped:
            self._stopped()
        except OmniVatError as error:
            log.info("a job was refused: %s", error)
            self._end("failed", error.with_traceback(None))  # it would keep what the work held
        except BaseException:  # for any error: a caller waits for the end
            log.exception("a job failed")
            self._end("failed", UnexpectedError(UNEXPECTED))
        else:
            self.state = "done"
            self.future.set_result(value)
        with self.lane.changed:
            self.lane.running.discard(self)
            self.lane.let_in()
        TRIM.soon()

    def _stopped(self) -> None:
        self._end("cancelled", CancelledError("This work was cancelled."))

    def _end(self, state: State, error: OmniVatError) -> None:
        self.since = monotonic()
        self.state = state
        self.future.set_exception(error)


class Jobs:
    """Runs jobs in lanes; lanes are independent of one another."""

    def __init__(self) -> None:
        self._threads = ThreadPoolExecutor(MOST_THREADS, "job")
        self._lanes = {name: Lane(number, self._threads) for name, number in SLOTS.items()}
        self._numbers = count()

    def start(
        self,
        work: Callable[[Job[T]], T],
        *,
        lane: str,
        owner: str = "",
        visitor: str = "",
        priority: int = 0,
        deadline_s: float = inf,
    ) -> Job[T]:
        """Put work in the queue of a lane; return the job.

        owner       owner of the job, for `cancel_owner`
        visitor     whose pictures and heads the job finds; see `app.shared.requests.visitor_of`
        priority    smaller numbers run first; a running job yields at its next check
        deadline_s  seconds of running, without waiting

        Raises BusyError if too many jobs are waiting, or half as many of the visitor.
        """
        line, requests = self._lanes[lane], self._lanes["quick"]
        with line.changed:
            own = sum(job.visitor == visitor for job in line.waiting)
            if len(line.waiting) >= WAITING_JOBS or (visitor and own >= WAITING_JOBS // 2):
                raise BusyError("Too much is waiting here already; try again in a minute.")
            number = next(self._numbers)
            job = Job(work, line, requests, owner, visitor, priority, deadline_s, number)
            line.waiting.append(job)
            line.let_in()
        return job

    def cancel_owner(self, owner: str) -> None:
        """Stop every job of an owner."""
        for job in self._all():
            if job.owner == owner:
                job.cancel()

    def close(self, wait_s: float = 2.0) -> None:
        """Stop all jobs, and wait briefly for threads to end."""
        everything = self._all()
        for job in everything:
            job.cancel()
        ended([job.future for job in everything], wait_s)
        self._threads.shutdown(wait=False)

    def _all(self) -> list[Job[Any]]:
        return [job for line in self._lanes.values() for job in (*line.running, *line.waiting)]
