"""One UMAP map per order, each started from its neighbour's."""

from collections.abc import Iterable, Iterator

from torch import Tensor

from omnivat.projection import torch_umap

WARM_STEPS, WARM_RATE = 60, 0.1


def chain(features: Iterable[Tensor], *, seed: int = 0, neighbours: int = 15) -> Iterator[Tensor]:
    """Give a map (N, 2) for each (N, D) as it comes; the first starts cold.

    features   the same N rows at neighbouring orders, in order

    Maps so made are as trustworthy as ones made apart and move far less from one order to the
    next (`python -m benchmarks.projection`). Each is exact for its own order: none is made by
    tweening. One order is held at a time.
    """
    before: Tensor | None = None
    for points in features:
        before = following(points, before, seed=seed, neighbours=neighbours)
        yield before


def following(
    points: Tensor, before: Tensor | None, *, seed: int = 0, neighbours: int = 15
) -> Tensor:
    """Return the map (N, 2) of points (N, D) that follows the map `before`, or a first one.

    A later map takes WARM_STEPS steps, as its start is nearly right, at WARM_RATE, so that rows
    keep their place.
    """
    if before is None:
        return torch_umap.project(points, seed=seed, neighbours=neighbours)
    return torch_umap.project(
        points, seed=seed, neighbours=neighbours, steps=WARM_STEPS, rate=WARM_RATE, start=before
    )
