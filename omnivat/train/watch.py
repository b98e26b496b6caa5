"""What a caller sees of a training while it runs, and how the caller stops it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from omnivat.errors import OmniVatError
from omnivat.progress import OnStep, Step, ignore

if TYPE_CHECKING:
    from omnivat.model.head import OmniVaT

OnEpoch = Callable[[dict[str, float], "OmniVaT"], None]


class TrainingCancelled(OmniVatError):
    """The caller stopped the training. Nothing was written."""


def never() -> bool:
    """Return False: the training runs to its end."""
    return False


def _no_epoch(record: dict[str, float], model: "OmniVaT") -> None:
    """Take the report of an epoch and do nothing with it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Watch:
    """Callbacks of one training.

    on_step    gets every optimiser step
    on_epoch   gets the record of every epoch and the live model, in training mode
    cancelled  is called before every step; training stops once it returns True
    done       steps of the work that came before this training
    whole      steps of all the work; those of this training where 0
    """

    on_step: OnStep = ignore
    on_epoch: OnEpoch = _no_epoch
    cancelled: Callable[[], bool] = never
    done: int = 0
    whole: int = 0

    def step(self, done: int, total: int, text: str) -> None:
        """Report a step. Raises TrainingCancelled when the caller wants to stop."""
        if self.cancelled():
            raise TrainingCancelled("Training was cancelled; nothing was written.")
        self.on_step(Step(done=self.done + done, total=self.whole or total, text=text))

    def part(self, done: int, whole: int) -> "Watch":
        """Return the watch of a part of a longer work, after `done` of `whole` steps."""
        return replace(self, done=done, whole=whole)

    def steps_only(self) -> "Watch":
        """Return the same watch without reports of epochs."""
        return replace(self, on_epoch=_no_epoch)
