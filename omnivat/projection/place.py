"""Place new points on an existing map: exactly if it is linear, else between neighbours."""

from typing import NamedTuple

import torch
from torch import Tensor

from omnivat.projection.neighbours import nearest
from omnivat.shapes import require_shapes

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
    queries, points, flat = queries.double(), points.double(), flat.double()
    known = affine(points, flat)
    if known is None:
        return Placed(place(queries, points, flat), exact=False)
    return Placed(queries @ known[:-1] + known[-1], exact=True)


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


def place(queries: Tensor, points: Tensor, flat: Tensor, *, k: int = 8) -> Tensor:
    """Return the places of new rows between their neighbours on an existing map.

    queries  (Q, D) new features
    points   (N, D) the features of the map, at the same order
    flat     (N, 2) the map; a NaN row makes places next to it NaN
    k        number of neighbours; small sets use all rows
    return   (Q, 2) mean of the neighbours' places, weighted by exp(-(d - nearest) / mean excess)

    A row of the map gets its own place. The map does not change. For a linear map (PCA), `placed`
    and `pca.Basis.place` are exact.
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
