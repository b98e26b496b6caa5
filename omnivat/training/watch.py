"""What a training reports."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from omnivat.head.head import OmniVaT
from omnivat.kit.progress import OnStep, Step, checkpoint, ignore

OnEpoch = Callable[[dict[str, float], OmniVaT], None]


def _no_epoch(record: dict[str, float], model: OmniVaT) -> None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Watch:
    """Callbacks of one training.

    on_step   called at every optimiser step
    on_epoch  called with the record of every epoch and the model, in training mode
    done      steps finished before this training
    whole     steps in total; 0 means those of this training
    """

    on_step: OnStep = ignore
    on_epoch: OnEpoch = _no_epoch
    done: int = 0
    whole: int = 0

    def step(self, done: int, total: int, text: str) -> None:
        """Report a step, at which the training can end (`omnivat.kit.progress.checkpoint`)."""
        checkpoint()
        self.on_step(Step(done=self.done + done, total=self.whole or total, text=text))

    def part(self, done: int, whole: int) -> "Watch":
        """Return the watch for a part of a longer task, after `done` of `whole` steps."""
        return replace(self, done=done, whole=whole)

    def steps_only(self) -> "Watch":
        """Return the same watch without reports of epochs."""
        return replace(self, on_epoch=_no_epoch)


UNWATCHED = Watch()
