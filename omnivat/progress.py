"""Progress reports."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One progress report: `done` of `total` (0 if unknown), and the current step."""

    done: int
    total: int
    text: str = ""


OnStep = Callable[[Step], None]


def ignore(_: Step) -> None:
    """Ignore a progress report."""
