"""Rotate and mirror maps to match neighbouring maps."""

from collections.abc import Iterable, Iterator

import torch
from torch import Tensor

from omnivat.shapes import require_shapes


def aligned(flat: Tensor, to: Tensor) -> Tensor:
    """Rotate or mirror a centred map about the origin to match another.

    flat, to  (N, 2) maps of the same rows, both centred
    return    (N, 2); distances between its points do not change

    Source: Schönemann, Psychometrika 31:1-10, 1966 (the orthogonal Procrustes problem).
    """
    require_shapes(flat=(flat, "N C"), to=(to, "N C"))
    left, _, right = torch.linalg.svd((flat.T @ to).double())
    turn: Tensor = (left @ right).to(flat.dtype)
    return flat @ turn


def chained(maps: Iterable[Tensor]) -> Iterator[Tensor]:
    """Yield centred maps (N, 2), each aligned to the previous one."""
    before: Tensor | None = None
    for flat in maps:
        before = flat if before is None else aligned(flat, before)
        yield before
