"""Source-side evidence: scores of candidate settings on held-out objects of the source."""

from collections.abc import Callable, Mapping
from typing import TypeVar

import torch
from torch import Tensor

from omnivat.data.splits import hold_out
from omnivat.kit.progress import checkpoint
from omnivat.kit.seeding import derive_seed
from omnivat.measure.gaps.calibration import nll
from omnivat.study.baselines.contract import Fitted, Source

C = TypeVar("C")
REPEATS, FRACTION = 4, 0.25


def folds(source: Source, repeats: int = REPEATS) -> list[tuple[Tensor, Tensor]]:
    """Return folds (training rows, held-out rows): whole objects, a quarter of each class.

    For one seed, all methods get the same folds. Empty if no class has two objects.
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


def best(
    source: Source,
    candidates: Mapping[str, C],
    fit: Callable[[Source, C], Fitted],
    *,
    repeats: int = REPEATS,
) -> str:
    """Return the candidate with the lowest log loss on held-out objects; accuracy breaks ties.

    return   its name; what another seed chose on this source (`Source.settled`); the first
             candidate if it is the only one or nothing can be held out
    """
    if found := [name for name in candidates if name in source.settled]:
        return found[0]
    # Minus the log loss, which is finer near 100 %, then right answers: few objects are held out,
    # so accuracy ties, or depends on one object.
    ranks = dict.fromkeys(candidates, (0.0, 0))
    for rows, held in folds(source, repeats) if len(candidates) > 1 else []:
        part, rest = source.select(rows), source.select(held)
        for name, candidate in candidates.items():
            checkpoint()
            shares = fit(part, candidate).predict(rest.vis, rest.tac)["fused"]
            gain, right = ranks[name]
            right += int((shares.argmax(-1) == rest.labels).sum())
            ranks[name] = gain - float(nll(shares, rest.labels)), right
    return max(ranks, key=ranks.__getitem__)  # the first one of equals
