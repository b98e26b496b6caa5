"""Put new points on a map that exists: exactly where it is linear, else between neighbours."""

from typing import NamedTuple

import torch
from torch import Tensor

from omnivat.projection.neighbours import nearest
from omnivat.shapes import require_shapes

EXACT = 1e-3  # of the map's radius: an affine map that fits every point this well is the map


class Placed(NamedTuple):
    """Where rows fall on a map, and whether that is exact."""

    places: Tensor  # (Q, 2)
    exact: bool


def placed(queries: Tensor, points: Tensor, flat: Tensor) -> Placed:
    """Return where new rows fall on the map of known ones, in double precision.

    queries  (Q, D) new features
    points   (N, D) the features that the map was made of, at the same order
    flat     (N, 2) the map, as it was drawn: turned, mirrored or rounded

    A linear map (PCA) is recovered from the points and places new rows exactly; on any other map
    they fall between their nearest neighbours.
    """
    queries, points, flat = queries.double(), points.double(), flat.double()
    known = affine(points, flat)
    if known is None:
        return Placed(place(queries, points, flat), exact=False)
    return Placed(queries @ known[:-1] + known[-1], exact=True)


def affine(points: Tensor, flat: Tensor) -> Tensor | None:
    """Return the affine map (D + 1, 2) from points (N, D) to flat (N, 2), or None.

    None where no affine map fits every point, or where points are too few to tell.
    """
    if len(points) <= points.shape[1] + 1:
        return None
    wide = torch.cat((points, points.new_ones(len(points), 1)), dim=1)
    found: Tensor = torch.linalg.lstsq(wide, flat, rcond=1e-9, driver="gelsd").solution
    radius = (flat - flat.mean(0)).abs().max()
    off = (wide @ found - flat).abs().max()
    return found if bool(off <= EXACT * radius) else None


def place(queries: Tensor, points: Tensor, flat: Tensor, *, k: int = 8) -> Tensor:
    """Return where new rows fall on the map of known ones.

    queries  (Q, D) new features
    points   (N, D) the features that the map was made of, at the same order
    flat     (N, 2) the map; one NaN row leaves its neighbours' places unknown
    k        neighbours to lie between; small sets use all they have
    return   (Q, 2) mean of the neighbours' places, weighted by exp(-(d - nearest) / mean excess)

    A row that is already there falls on its own point. The map itself does not move; a linear
    map (PCA) places new rows exactly with `placed` or `pca.Basis.place` instead.
    """
    require_shapes(points=(points, "N D"), queries=(queries, "Q D"), flat=(flat, "N C"))
    found = nearest(points, min(k, len(points)), queries=queries)
    beyond = found.distance - found.distance[:, :1]
    tiny = torch.finfo(points.dtype).tiny
    weight = (-beyond / beyond.mean(1, keepdim=True).clamp_min(tiny)).exp()
    scale = 1e-6 * (points - points.mean(0)).norm(dim=1).mean()
    there = found.distance <= scale
    weight = torch.where(there.any(1, keepdim=True), there.to(weight.dtype), weight)
    return (flat[found.index] * (weight / weight.sum(1, keepdim=True))[..., None]).sum(1)
