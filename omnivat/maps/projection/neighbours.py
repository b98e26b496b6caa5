"""Exact nearest neighbours by matrix product, and new points on an existing map: exactly if it is
linear, else between neighbours."""

from collections.abc import Sequence
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


class Searched(NamedTuple):
    """Rows about their middle, to be searched again and again."""

    rows: Tensor  # (N, D); distances do not depend on the origin
    middle: Tensor  # (D,); a near one keeps the squares small and exact
    squares: Tensor  # (N,)


def searched(points: Tensor) -> Searched:
    """Return rows (N, D) for many calls of `nearest` or `place`. Raises DataError for values that
    are not finite or above SUMMED.
    """
    (points,) = features(0, most=SUMMED, points=points)
    middle = points.mean(0)
    rows = points - middle
    return Searched(rows, middle, rows.square().sum(1))


def nearest(points: Tensor | Searched, k: int, *, queries: Tensor | None = None) -> Neighbours:
    """Find the k nearest rows of `points` for each query, by Euclidean distance.

    points   (N, D), or `searched` of them
    queries  (M, D); by default the points themselves, where a point is not its own neighbour
    return   (M, k) each; the order of rows at equal distances is not defined

    Exact up to rounding, O(N M D), BLOCK rows of distances at a time.
    Raises SettingsError if there are fewer than k other rows, DataError for values that are not
    finite or above SUMMED.
    """
    own = queries is None
    if queries is not None and not isinstance(points, Searched):
        points, queries = features(0, most=SUMMED, points=points, queries=queries)  # of one type
    among = points if isinstance(points, Searched) else searched(points)
    around = among.rows
    if queries is not None:
        (queries,) = features(0, most=SUMMED, queries=queries)
        require_shapes(points=(among.rows, "N D"), queries=(queries, "Q D"))
        around = queries.to(around.dtype) - among.middle
    others = len(among.rows) - own
    if not 1 <= k <= others:
        raise SettingsError(f"{k} neighbours were requested among {others}; choose 1 to {others}.")
    found = []
    for start in range(0, len(around) or 1, BLOCK):
        checkpoint()
        rows = around[start : start + BLOCK]
        nearness = torch.addmm(among.squares, rows, among.rows.T, alpha=-2)
        if own:
            place = torch.arange(len(rows), device=rows.device)
            nearness[place, place + start] = torch.inf
        index = nearness.topk(k, largest=False).indices
        # from differences, which is exact for near-duplicates
        distance, order = (among.rows[index] - rows[:, None]).norm(dim=2).sort(dim=1)
        found.append((index.gather(1, order), distance))
    return Neighbours(*(torch.cat(parts) for parts in zip(*found, strict=True)))


PLACED_BY = 8  # neighbours of a new row
SAME = 1e-5  # of the mean distance to the middle: float32 rows of one pair, from two batches
EXACT = 1e-3  # of the map's radius; an affine map with smaller errors counts as the map


def placed_by(
    known: Tensor | None, queries: Tensor, points: Tensor | Searched, flat: Tensor
) -> Tensor:
    """Return the places (Q, 2) of new rows on an existing map.

    known    `affine` of the points and the map: places are exact; None: new rows lie between their
             nearest neighbours
    queries  (Q, D) new features
    points   (N, D) the features of the map, at the same order, or `searched` of them
    flat     (N, 2) the map as drawn: rotated, mirrored or rounded
    """
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


def place(queries: Tensor, points: Tensor | Searched, flat: Tensor) -> Tensor:
    """Return the places of new rows between their neighbours on an existing map.

    queries  (Q, D) new features
    points   (N, D) the features of the map, at the same order, or `searched` of them
    flat     (N, 2) the map; a NaN row makes places next to it NaN
    return   (Q, 2) mean of the neighbours' places, weighted by exp(-(d - nearest) / mean excess);
             of PLACED_BY neighbours, or of all rows of a small set

    A row of the map gets its own place. The map does not change. For a linear map (PCA),
    `placed_by` and `pca.Basis.place` are exact.
    """
    among = points if isinstance(points, Searched) else searched(points)
    require_shapes(points=(among.rows, "N D"), queries=(queries, "Q D"), flat=(flat, "N C"))
    return place_each(queries[None], [among], [flat])[0]


def place_each(queries: Tensor, among: Sequence[Searched], flat: Sequence[Tensor]) -> Tensor:
    """Return `place` of rows (S, Q, D) on S maps, (S, Q, 2): what is small is one batch."""
    found = [
        nearest(points, min(PLACED_BY, len(points.rows)), queries=rows)
        for points, rows in zip(among, queries, strict=True)
    ]
    distance = torch.stack([near.distance for near in found])
    beyond = distance - distance[..., :1]
    tiny = torch.finfo(beyond.dtype).tiny
    weight = (-beyond / beyond.mean(-1, keepdim=True).clamp_min(tiny)).exp()
    scale = SAME * torch.stack([points.squares.sqrt().mean() for points in among])
    there = distance <= scale[:, None, None]
    weight = torch.where(there.any(-1, keepdim=True), there.to(weight.dtype), weight)
    share = (weight / weight.sum(-1, keepdim=True))[..., None]
    places = torch.stack([drawn[near.index] for drawn, near in zip(flat, found, strict=True)])
    mean: Tensor = (places * share).sum(2)
    return mean
