"""Exact nearest neighbours by matrix product."""

from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.errors import SettingsError
from omnivat.shapes import require_shapes

BLOCK = 1024  # rows of the distance matrix held at once


@dataclass(frozen=True, slots=True)
class Neighbours:
    """The k nearest rows of each row, nearest first: index (N, k), distance (N, k)."""

    index: Tensor
    distance: Tensor


def nearest(points: Tensor, k: int, *, queries: Tensor | None = None) -> Neighbours:
    """Find the k nearest rows of `points` for each query, by Euclidean distance.

    points   (N, D)
    queries  (M, D); by default the points themselves, where a point is not its own neighbour
    return   (M, k) each; the order of rows at equal distances is not defined

    Exact up to rounding, O(N M D), BLOCK rows of distances at a time.
    Raises SettingsError if there are fewer than k other rows.
    """
    require_shapes(points=(points, "N D"))
    own = queries is None
    queries = points if queries is None else queries
    require_shapes(points=(points, "N D"), queries=(queries, "M D"))
    others = len(points) - own
    if not 1 <= k <= others:
        raise SettingsError(f"{k} neighbours were requested among {others}; choose 1 to {others}.")
    # distances do not depend on the origin; a near one keeps the squares small and exact
    middle = points.mean(0)
    points, queries = points - middle, queries - middle
    squares = points.square().sum(1)
    found = []
    for start in range(0, len(queries), BLOCK):
        rows = queries[start : start + BLOCK]
        nearness = torch.addmm(squares, rows, points.T, alpha=-2)
        if own:
            place = torch.arange(len(rows), device=rows.device)
            nearness[place, place + start] = torch.inf
        index = nearness.topk(k, largest=False).indices
        found.append(_sorted(rows, points, index))
    return Neighbours(*(torch.cat(parts) for parts in zip(*found, strict=True)))


def _sorted(rows: Tensor, points: Tensor, index: Tensor) -> tuple[Tensor, Tensor]:
    """Compute the chosen distances from differences, which is exact for near-duplicates."""
    distance = (points[index] - rows[:, None]).norm(dim=2)
    distance, order = distance.sort(dim=1)
    return index.gather(1, order), distance
