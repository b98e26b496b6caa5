"""One UMAP map per order, each started from its neighbour's."""

from collections.abc import Iterable, Iterator

from torch import Tensor

from omnivat.projection import torch_umap

WARM_STEPS, WARM_RATE = 60, 0.1


def chain(
    features: Iterable[Tensor],
    *,
    seed: int = 0,
    neighbours: int = 15,
    steps: int = WARM_STEPS,
    rate: float = WARM_RATE,
) -> Iterator[Tensor]:
    """Give a map (N, 2) for each (N, D) as it comes; the first starts cold.

    features   the same N rows at neighbouring orders, in order
    steps      of every map but the first: its start is nearly right, so it needs fewer
    rate       of every map but the first: small, so that rows keep their place

    Maps so made are as trustworthy as ones made apart and move far less from one order to the
    next (`python -m benchmarks.projection`). Each is exact for its own order: none is made by
    tweening. One order is held at a time.
    """
    before: Tensor | None = None
    for points in features:
        if before is None:
            before = torch_umap.project(points, seed=seed, neighbours=neighbours)
        else:
            before = torch_umap.project(
                points, seed=seed, neighbours=neighbours, steps=steps, rate=rate, start=before
            )
        yield before
