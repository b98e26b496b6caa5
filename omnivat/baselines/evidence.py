"""Source-side evidence: how well a choice does on objects of the source that were held out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

import torch
from torch import Tensor
from torch.nn.functional import nll_loss

from omnivat.baselines.contract import Source
from omnivat.data.splits import hold_out
from omnivat.seeding import derive_seed

C = TypeVar("C")
REPEATS, FRACTION = 4, 0.25


def folds(source: Source, repeats: int = REPEATS) -> list[tuple[Tensor, Tensor]]:
    """Return (rows to fit, rows held out) a few times; whole objects, a quarter of each class.

    The same for every method at one seed. Empty where no class has two objects.
    """
    found = []
    for repeat in range(repeats):
        seed = derive_seed(source.seed, "folds", repeat)
        held = torch.from_numpy(
            hold_out(source.objects, source.labels.numpy(), FRACTION, seed=seed)
        )
        if held.any():
            found.append(((~held).nonzero()[:, 0], held.nonzero()[:, 0]))
    return found


@dataclass(slots=True)
class Score:
    """Held-out answers added up over folds."""

    right: int = 0
    loss: float = 0.0

    def add(self, probabilities: Tensor, labels: Tensor) -> None:
        """Count one fold's answers: probabilities (B, K), labels (B,)."""
        self.right += int((probabilities.argmax(-1) == labels).sum())
        self.loss += log_loss(probabilities, labels)

    @property
    def rank(self) -> tuple[float, int]:
        """What to maximise: a low log loss, then right answers.

        Few objects are held out: right answers tie or turn on one object, and then the choice of a
        regression's C falls on any of seven powers of ten.
        """
        return -self.loss, self.right


def log_loss(probabilities: Tensor, labels: Tensor) -> float:
    """Mean negative log probability of the true class, nats; finer than accuracy near 100 %."""
    return float(nll_loss(probabilities.clamp_min(1e-12).log(), labels))


def best(
    source: Source,
    candidates: Mapping[str, C],
    fit: Callable[[Source, C], Callable[[Tensor, Tensor], Tensor]],
    *,
    repeats: int = REPEATS,
) -> str:
    """Return the candidate with the lowest log loss on held-out objects; ties by right answers.

    fit      (part of the source, candidate) -> (vis, tac) -> probabilities (B, K)
    return   its name; the first where there is one only, or nothing can be held out
    """
    first = next(iter(candidates))
    splits = folds(source, repeats) if len(candidates) > 1 else []
    if not splits:
        return first
    scores = {name: Score() for name in candidates}
    for rows, held in splits:
        part, rest = source.select(rows), source.select(held)
        for name, candidate in candidates.items():
            scores[name].add(fit(part, candidate)(rest.vis, rest.tac), rest.labels)
    return max(scores, key=lambda name: scores[name].rank)
