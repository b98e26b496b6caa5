"""Exact nearest neighbours by matrix product, and new points on an existing map: exactly if it is
linear, else between neighbours."""

from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from omnivat.kit.errors import SettingsError
from omnivat.kit.progress import checkpoint
from omnivat.kit.shapes import SUMMED, features, require_shapes

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
    Raises SettingsError if there are fewer than k other rows, DataError for values that are not
    finite or above SUMMED.
    """
    own = queries is None
    queries = points if queries is None else queries
    points, queries = features(0, most=SUMMED, points=points, queries=queries)
    others = points.shape[0] - own
    if not 1 <= k <= others:
        raise SettingsError(f"{k} neighbours were requested among {others}; choose 1 to {others}.")
    # distances do not depend on the origin; a near one keeps the squares small and exact
    middle = points.mean(0)
    points, queries = points - middle, queries - middle
    squares = points.square().sum(1)
    found = []
    for start in range(0, len(queries) or 1, BLOCK):
        checkpoint()
        rows = queries[start : start + BLOCK]
        nearness = torch.addmm(squares, rows, points.T, alpha=-2)
        if own:
            place = torch.arange(len(rows), device=rows.device)
            nearness[place, place + start] = torch.inf
        index = nearness.topk(k, largest=False).indices
        # from differences, which is exact for near-duplicates
        distance, order = (points[index] - rows[:, None]).norm(dim=2).sort(dim=1)
        found.append((index.gather(1, order), distance))
    return Neighbours(*(torch.cat(parts) for parts in zip(*found, strict=True)))


PLACED_BY = 8  # neighbours of a new row
SAME = 1e-5  # of the mean distance to the middle: float32 rows of one pair, from two batches
EXACT = 1e-3  # of the map's radius; an affine map with smaller errors counts as the map


class Placed(NamedTuple):
    """Places of rows on a map, and whether they are exact."""

    places: Tensor  # (Q, 2)
    exact: bool


def placed(queries: Tensor, points: Tensor, flat: Tensor) -> Placed:
    """Return the places of new rows on an existing map, in double precision.

    queries  (Q, D) new features
    points   (N, D) the features of the map, at the same order
    flat     (N, 2) the map as drawn: rotated, mirrored or rounded

    A linear map (PCA) is recovered from the points and places new rows exactly. On other maps, new
    rows lie between their nearest neighbours.
    """
    queries, points = (x.double() for x in features(most=SUMMED, queries=queries, points=points))
    flat = torch.as_tensor(flat).double()
    known = affine(points, flat)
    return Placed(placed_by(known, queries, points, flat), exact=known is not None)


def placed_by(known: Tensor | None, queries: Tensor, points: Tensor, flat: Tensor) -> Tensor:
    """Return `placed` for what `affine` gives of the points and the map."""
    if known is None:
        return place(queries, points, flat)
    return queries.double() @ known[:-1] + known[-1]


def affine(points: Tensor, flat: Tensor) -> Tensor | None:
    """Return the affine map (D + 1, 2) from points (N, D) to flat (N, 2), or None.

    None if no affine map fits every point, or if there are too few points.
    """
    if len(points) <= points.shape[1] + 1:
        return None
    wide = torch.cat((points, points.new_ones(len(points), 1)), dim=1)
    found: Tensor = torch.linalg.lstsq(wide, flat, rcond=1e-9, driver="gelsd").solution
    radius = (flat - flat.mean(0)).abs().max()
    off = (wide @ found - flat).abs().max()
    return found if bool(off <= EXACT * radius) else None


def place(queries: Tensor, points: Tensor, flat: Tensor) -> Tensor:
    """Return the places of new rows between their neighbours on an existing map.

    queries  (Q, D) new features
    points   (N, D) the features of the map, at the same order
    flat     (N, 2) the map; a NaN row makes places next to it NaN
    return   (Q, 2) mean of the neighbours' places, weighted by exp(-(d - nearest) / mean excess);
             of PLACED_BY neighbours, or of all rows of a small set

    A row of the map gets its own place. The map does not change. For a linear map (PCA), `placed`
    and `pca.Basis.place` are exact.
    """
    require_shapes(points=(points, "N D"), queries=(queries, "Q D"), flat=(flat, "N C"))
    index, share = neighbour_shares(queries, points)
    return (flat[index] * share[..., None]).sum(1)


def neighbour_shares(queries: Tensor, points: Tensor) -> tuple[Tensor, Tensor]:
    """Return the neighbours of each row (Q, k) and their shares in its place."""
    found = nearest(points, min(PLACED_BY, points.shape[0]), queries=queries)
    beyond = found.distance - found.distance[:, :1]
    tiny = torch.finfo(points.dtype).tiny
    weight = (-beyond / beyond.mean(1, keepdim=True).clamp_min(tiny)).exp()
    scale = SAME * (points - points.mean(0)).norm(dim=1).mean()
    there = found.distance <= scale
    weight = torch.where(there.any(1, keepdim=True), there.to(weight.dtype), weight)
    return found.index, weight / weight.sum(1, keepdim=True)
