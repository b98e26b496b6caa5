"""Progress reports, and points at which work whose result nobody wants any more can end."""

import time
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One progress report: `done` of `total` (0 if unknown), the current step, and the time
    left.
    """

    done: int
    total: int
    text: str = ""
    left: str = ""


OnStep = Callable[[Step], None]

# called at every checkpoint of the work in this context; an error that it raises ends the work
CHECK: ContextVar[Callable[[], None] | None] = ContextVar("check", default=None)


def checkpoint() -> None:
    """End the work here if its caller wants that; loops that may take a second call it in each
    step.
    """
    if check := CHECK.get():
        check()


def ignore(_: Step) -> None:
    """Ignore a progress report."""


def time_text(seconds: float) -> str:
    """Return a duration as text, in at most two units."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


class Pace:
    """The time left of some work, at the mean rate since its stage began."""

    def __init__(self) -> None:
        self._first: int | None = None  # steps at the start: an earlier run did some
        self._last, self._begun = 0, 0.0

    def left(self, step: Step) -> str:
        """Return "6 min 40 s left"; "" at the start or without a total."""
        now = time.monotonic()
        if self._first is None or step.done < self._last:
            self._first, self._begun = step.done, now
        self._last, done = step.done, step.done - self._first
        if done <= 0 or not step.total:
            return ""
        return f"{time_text((now - self._begun) * (step.total - step.done) / done)} left"
