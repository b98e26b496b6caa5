"""UMAP in torch: exact neighbours, the fuzzy graph, and a vectorised descent. No compilation.

Differences from umap-learn: neighbours are exact. Every edge attracts in every step with its
weight, whereas umap-learn samples edges in proportion to it. In every step, REPELLERS random rows
repel each row with the same mean strength. All rows move at once by force over degree; this keeps
the equilibria and prevents hubs from overshooting. The start is spectral or a given map.
"""

import math
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from omnivat.kit.progress import checkpoint
from omnivat.kit.seeding import derive_seed
from omnivat.kit.shapes import SUMMED, features, require_shapes
from omnivat.maps.projection import pca
from omnivat.maps.projection.neighbours import Neighbours, nearest, place

BISECTIONS = 32
NEIGHBOURS = 15  # of each row, itself included; umap-learn's default. Small sets use all rows


@dataclass(frozen=True, slots=True)
class Graph:
    """Undirected weighted edges over N rows: tail, head (M,) with tail != head, weight in (0,
    1].
    """

    tail: Tensor
    head: Tensor
    weight: Tensor
    rows: int


def fuzzy_graph(neighbours: Neighbours) -> Graph:
    """Connect each row to its neighbours with weight exp(-(d - nearest) / width), symmetrized.

    Widths are chosen so that the weights of a row add up to log2(k + 1). Weights u and v from the
    two ends of an edge give u + v - u v; each undirected edge is stored once. Source: McInnes,
    Healy and Melville, arXiv:1802.03426, section 3.1.
    """
    index, distance = neighbours.index, neighbours.distance
    rows, k = index.shape
    beyond = distance - distance[:, :1]
    weight = (-beyond / _widths(beyond, math.log2(k + 1))).exp()
    tail = torch.arange(rows, device=index.device)[:, None].expand_as(index)
    # the neighbour's weight for this row, or 0 if it does not list the row
    back = torch.where(index[index] == tail[..., None], weight[index], 0).sum(2)
    both = weight + back - weight * back
    once = (tail < index) | (back == 0)
    return Graph(tail[once], index[once], both[once], rows)


def _widths(beyond: Tensor, total: float) -> Tensor:
    """Return (N, 1) widths s with sum(exp(-beyond / s)) = total, by bisection."""
    low = torch.zeros_like(beyond[:, :1])
    high = torch.full_like(low, torch.inf)
    width = beyond.mean(1, keepdim=True).clamp_min(1e-12)
    for _ in range(BISECTIONS):
        too_wide = (-beyond / width).exp().sum(1, keepdim=True) > total
        high = torch.where(too_wide, width, high)
        low = torch.where(too_wide, low, width)
        width = torch.where(high.isinf(), 2 * width, (low + high) / 2)
    # rows with many equal distances would have width 0
    return width.clamp_min(1e-3 * beyond.mean().clamp_min(1e-12))


DIRECTIONS = 4  # vectors in the iteration; two or three are used
ROUNDS, WALKS = 6, 5  # how often the vectors are orthogonalized, and iterations before each time
RADIUS = 10.0


def spectral_map(graph: Graph, *, seed: int = 0, dimensions: int = 2) -> Tensor:
    """Return a rough map (N, dimensions) whose largest coordinate is RADIUS.

    It approximates the first non-constant eigenvectors of the normalised graph Laplacian by
    subspace iteration from a seeded start. Neighbours end up close together, and folds of a PCA map
    disappear. Thirty steps suffice for a start, but the eigenvectors are not converged.
    Source: Belkin and Niyogi, Neural Computation 15:1373-1396, 2003.
    """
    weight, rows = graph.weight, graph.rows
    degree = weight.new_zeros(rows).index_add_(0, graph.tail, weight)
    degree = degree.index_add_(0, graph.head, weight).clamp_min(1e-12)
    ends = torch.cat([graph.tail, graph.head])
    others = torch.cat([graph.head, graph.tail])
    step = (weight * (degree[graph.tail] * degree[graph.head]).rsqrt()).repeat(2)[:, None]

    def walked(x: Tensor) -> Tensor:
        return torch.zeros_like(x).index_add_(0, ends, step * x[others])

    constant = degree.sqrt()[:, None]
    constant = constant / constant.norm()
    like: dict[str, Any] = {"dtype": weight.dtype, "device": weight.device}
    generator = torch.Generator(weight.device).manual_seed(derive_seed(seed, "spectral"))
    directions = torch.randn((rows, min(DIRECTIONS, rows - 1)), generator=generator, **like)
    for _ in range(ROUNDS):
        for _ in range(WALKS):
            directions = directions + walked(directions)  # lazy walk: no negative eigenvalue
        directions = directions - constant @ (constant.T @ directions)
        directions = torch.linalg.qr(directions).Q
    turn = torch.linalg.eigh(directions.T @ walked(directions)).eigenvectors.flip(1)
    flat: Tensor = (directions @ turn[:, :dimensions]) / degree.sqrt()[:, None]
    return flat * (RADIUS / flat.abs().max().clamp_min(1e-30))


A, B = 1.5769, 0.8951  # of the curve 1 / (1 + A d^2B) for min_dist = 0.1, spread = 1
NEGATIVES = 5  # repulsions for each attraction, as in umap-learn
REPELLERS = 16
STEPS, RATE = 200, 0.5
MOST_ROWS = 12_000  # rows in the descent; more are placed afterwards
PLACED = 8192  # rows placed at once
CELLS_FROM, CELLS, RING = 100_000, 128, 16
WARM_STEPS, WARM_RATE = 60, 0.1  # of a map that starts from another
PUSH_LIMIT = 4.0  # umap-learn's bound on each part of one force; no attraction reaches it


def project(
    points: Tensor, *, seed: int = 0, dimensions: int = 2, start: Tensor | None = None
) -> Tensor:
    """Return a UMAP map of points (N, D) -> (N, dimensions).

    seed   the same seed, machine and thread count give the same map
    start  (N, dimensions) map of a neighbouring order to start from

    A given start is almost right, so its map takes only WARM_STEPS steps. The low rate WARM_RATE
    keeps rows in their places: maps of neighbouring orders are as trustworthy as independent ones
    and move far less (`benchmarks.projection` at 527730d).

    With more than MOST_ROWS rows, the descent uses a sample that depends only on the seed. Every
    other row is placed between its nearest neighbours in the sample; see `_spread`.
    """
    (points,) = features(most=SUMMED, points=points)
    if len(points) < dimensions + 2:
        return pca.project(points, dimensions=dimensions)
    if len(points) > MOST_ROWS:
        chosen = sample_of(len(points), seed).to(points.device)
        first = None if start is None else start[chosen]
        flat = project(points[chosen], seed=seed, dimensions=dimensions, start=first)
        return _spread(points, chosen, flat)
    graph = fuzzy_graph(nearest(points, min(NEIGHBOURS, len(points)) - 1))
    if start is not None:
        return descend(graph, start, steps=WARM_STEPS, rate=WARM_RATE, seed=seed)
    start = spectral_map(graph, seed=seed, dimensions=dimensions)
    return descend(graph, start, steps=STEPS, rate=RATE, seed=seed)


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


def sample_of(rows: int, seed: int) -> Tensor:
    """Return MOST_ROWS indices, ascending."""
    generator = torch.Generator().manual_seed(derive_seed(seed, "umap sample"))
    return torch.randperm(rows, generator=generator)[:MOST_ROWS].sort().values


def _spread(points: Tensor, chosen: Tensor, flat: Tensor) -> Tensor:
    """Return the map of all points: `flat` for the sample; others between neighbours.

    Beyond CELLS_FROM points, neighbours are sought among the sample's rows near the point's cell
    alone: rows belong to the nearest of CELLS pivots, and a cell looks at the RING nearest cells.
    """
    whole = flat.new_empty(len(points), flat.shape[1])
    whole[chosen] = flat
    known, left = points[chosen], torch.ones(len(points), dtype=torch.bool, device=points.device)
    left[chosen] = False
    rest = left.nonzero()[:, 0]
    pivots = known[:: -(-len(known) // (CELLS if len(points) > CELLS_FROM else 1))]
    ring = torch.cdist(pivots, pivots).topk(min(RING, len(pivots)), largest=False).indices
    cells = nearest(pivots, 1, queries=known).index[:, 0]
    home = torch.cat(
        [nearest(pivots, 1, queries=points[some]).index[:, 0] for some in rest.split(PLACED)]
    )
    for cell in home.unique():  # others hold rows of the sample alone
        near = torch.isin(cells, ring[cell]).nonzero()[:, 0]
        for some in rest[home == cell].split(PLACED):
            whole[some] = place(points[some], known[near], flat[near])
    return whole


def descend(graph: Graph, start: Tensor, *, steps: int, rate: float, seed: int) -> Tensor:
    """Move the rows of `start` (N, 2) by UMAP's forces; return the new places.

    rate  factor of force over degree in the first step; it decreases linearly to 0

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
        checkpoint()
        pull = attraction(places[:, tail] - places[:, head])  # (2, M)
        drawn = torch.randint(rows, (REPELLERS, rows), generator=generator, device=device)
        move = NEGATIVES * repulsion(places[:, None] - places[:, drawn]).mean(1)  # (2, N)
        move.index_add_(1, tail, pull * on_tail).index_add_(1, head, pull * on_head)
        places = places + rate * (1 - step / steps) * move
    return places.T.contiguous()


def attraction(gap: Tensor) -> Tensor:
    """Return the attraction of an edge on its tail; `gap` (2, ...) = tail - head."""
    squared = gap.square().sum(0).clamp_min(1e-12)
    power = squared.pow(B)
    strength = -2 * A * B * power / (squared * (1 + A * power))
    return gap * strength


def repulsion(gap: Tensor) -> Tensor:
    """Return the repulsion of a sampled row; `gap` (2, ...) = this - sampled. A row repels itself
    by 0.
    """
    squared = gap.square().sum(0)
    strength = 2 * B / ((1e-3 + squared) * (1 + A * squared.pow(B)))
    return (gap * strength).clamp(-PUSH_LIMIT, PUSH_LIMIT)
