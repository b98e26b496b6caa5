"""Turn and mirror maps so that neighbouring ones lie as nearly alike as they can."""

from collections.abc import Iterable, Iterator

import torch
from torch import Tensor

from omnivat.shapes import require_shapes


def aligned(flat: Tensor, to: Tensor) -> Tensor:
    """Turn or mirror a centred map about the origin to lie nearest to another.

    flat, to  (N, 2) maps of the same rows, both centred
    return    (N, 2); distances between its points are as they were: nothing is scaled

    Source: Schönemann, Psychometrika 31:1-10, 1966 (the orthogonal Procrustes problem).
    """
    require_shapes(flat=(flat, "N C"), to=(to, "N C"))
    left, _, right = torch.linalg.svd((flat.T @ to).double())
    turn: Tensor = (left @ right).to(flat.dtype)
    return flat @ turn


def chained(maps: Iterable[Tensor]) -> Iterator[Tensor]:
    """Give centred maps (N, 2) as they come, each aligned to the one before it."""
    before: Tensor | None = None
    for flat in maps:
        before = flat if before is None else aligned(flat, before)
        yield before
