"""UMAP in torch: exact neighbours, the fuzzy graph, and a vectorised descent. No compilation.

Differences from umap-learn: neighbours are exact. Every edge attracts in every step with its
weight, whereas umap-learn samples edges in proportion to it. In every step, REPELLERS random rows
repel each row with the same mean strength. All rows move at once by force over degree; this keeps
the equilibria and prevents hubs from overshooting. The start is spectral (`spectral.py`) or a given
map.
"""

import torch
from torch import Tensor

from omnivat.projection import pca
from omnivat.projection.fuzzy import Graph, fuzzy_graph
from omnivat.projection.neighbours import nearest
from omnivat.projection.place import place
from omnivat.projection.spectral import spectral_map
from omnivat.seeding import derive_seed

A, B = 1.5769, 0.8951  # of the curve 1 / (1 + A d^2B) for min_dist = 0.1, spread = 1
NEGATIVES = 5  # repulsions for each attraction, as in umap-learn
REPELLERS = 16
STEPS, RATE = 200, 0.5
MOST_ROWS = 12_000  # rows in the descent; more are placed afterwards
PLACED = 8192  # rows placed at once
PULL_LIMIT = 4.0  # umap-learn's bound on each part of one force


def project(
    points: Tensor,
    *,
    seed: int = 0,
    neighbours: int = 15,
    steps: int = STEPS,
    rate: float = RATE,
    start: Tensor | None = None,
) -> Tensor:
    """Return a UMAP map of points (N, D) -> (N, 2).

    seed        the same seed, machine and thread count give the same map
    neighbours  of each row, itself included as in umap-learn; small sets use all rows
    steps       of the descent
    rate        factor of force over degree in the first step; it decreases linearly to 0
    start       (N, 2) initial map, such as that of a neighbouring order

    With more than MOST_ROWS rows, the descent uses a sample that depends only on the seed. Every
    other row is placed between its nearest neighbours in the sample.
    """
    if len(points) < 4:
        return pca.project(points)
    if len(points) > MOST_ROWS:
        chosen = sample_of(len(points), seed).to(points.device)
        first = None if start is None else start[chosen]
        flat = project(
            points[chosen], seed=seed, neighbours=neighbours, steps=steps, rate=rate, start=first
        )
        return _spread(points, chosen, flat)
    graph = fuzzy_graph(nearest(points, min(neighbours, len(points)) - 1))
    start = spectral_map(graph, seed=seed) if start is None else start
    return descend(graph, start, steps=steps, rate=rate, seed=seed)


def sample_of(rows: int, seed: int) -> Tensor:
    """Return the indices of the MOST_ROWS sampled rows, ascending."""
    generator = torch.Generator().manual_seed(derive_seed(seed, "umap sample"))
    return torch.randperm(rows, generator=generator)[:MOST_ROWS].sort().values


def _spread(points: Tensor, chosen: Tensor, flat: Tensor) -> Tensor:
    """Return the map of all points: `flat` for the sample; others between neighbours."""
    known = points[chosen]
    whole = torch.cat([place(some, known, flat) for some in points.split(PLACED)])
    whole[chosen] = flat
    return whole


def descend(graph: Graph, start: Tensor, *, steps: int, rate: float, seed: int) -> Tensor:
    """Move the rows of `start` (N, 2) by UMAP's forces; return the new places.

    Source: McInnes, Healy and Melville, arXiv:1802.03426, section 3.2 and appendix C.
    """
    rows, device = graph.rows, start.device
    generator = torch.Generator(device).manual_seed(derive_seed(seed, "umap"))
    # rows at the same place would never separate: the force has no direction
    jitter = torch.randn(start.shape, generator=generator, dtype=start.dtype, device=device)
    # all x, then all y: twice as fast as pairs
    places = (start + 1e-4 * jitter).T.contiguous()  # (2, N)
    tail, head = graph.tail, graph.head
    degree = start.new_zeros(rows).index_add_(0, tail, graph.weight)
    degree = degree.index_add_(0, head, graph.weight).clamp_min(1e-12)
    # umap-learn visits each edge from both ends: hence twice the weight
    on_tail, on_head = 2 * graph.weight / degree[tail], -2 * graph.weight / degree[head]
    for step in range(steps):
        pull = attraction(places[:, tail] - places[:, head])  # (2, M)
        drawn = torch.randint(rows, (REPELLERS, rows), generator=generator, device=device)
        move = NEGATIVES * repulsion(places[:, None] - places[:, drawn]).mean(1)  # (2, N)
        move.index_add_(1, tail, pull * on_tail).index_add_(1, head, pull * on_head)
        places = places + rate * (1 - step / steps) * move
    return places.T.contiguous()


def attraction(gap: Tensor) -> Tensor:
    """Attraction of an edge on its tail; `gap` (2, ...) = tail - head."""
    squared = gap.square().sum(0).clamp_min(1e-12)
    power = squared.pow(B)
    strength = -2 * A * B * power / (squared * (1 + A * power))
    return (gap * strength).clamp(-PULL_LIMIT, PULL_LIMIT)


def repulsion(gap: Tensor) -> Tensor:
    """Repulsion of a sampled row; `gap` (2, ...) = this - sampled. A row repels itself by 0."""
    squared = gap.square().sum(0)
    strength = 2 * B / ((1e-3 + squared) * (1 + A * squared.pow(B)))
    return (gap * strength).clamp(-PULL_LIMIT, PULL_LIMIT)
