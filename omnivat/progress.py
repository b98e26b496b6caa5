"""How long work tells its caller how far it is."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One report of progress: `done` of `total` (0 when unknown) and what is being done."""

    done: int
    total: int
    text: str = ""


OnStep = Callable[[Step], None]


def ignore(_: Step) -> None:
    """Take a report of progress and do nothing with it."""
