"""One map for each p, each started from its neighbour and aligned with it."""

from collections.abc import Iterable, Iterator

import torch
from torch import Tensor

from omnivat.projection import torch_umap
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


WARM_STEPS, WARM_RATE = 60, 0.1


def chain(features: Iterable[Tensor], *, seed: int = 0, neighbours: int = 15) -> Iterator[Tensor]:
    """Yield a map (N, 2) for each (N, D); the first has no start.

    features   the same N rows at neighbouring orders, in order

    Such maps are as trustworthy as independent maps and move far less from one order to the next
    (`python -m benchmarks.projection`). Each is computed at its own order; nothing is interpolated.
    Memory holds one order at a time.
    """
    before: Tensor | None = None
    for points in features:
        before = following(points, before, seed=seed, neighbours=neighbours)
        yield before


def following(points: Tensor, before: Tensor | None, *, seed: int = 0, neighbours: int = 15) -> Tensor:
    """Return the map (N, 2) of points (N, D), started from the map `before` if given.

    The start is almost right, so a later map takes only WARM_STEPS steps. The low rate WARM_RATE
    keeps rows in their places.
    """
    if before is None:
        return torch_umap.project(points, seed=seed, neighbours=neighbours)
    return torch_umap.project(points, seed=seed, neighbours=neighbours, steps=WARM_STEPS, rate=WARM_RATE, start=before)
