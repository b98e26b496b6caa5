"""Put new points on a map that exists, between their nearest neighbours."""

import torch
from torch import Tensor

from omnivat.projection.neighbours import nearest
from omnivat.shapes import require_shapes


def place(queries: Tensor, points: Tensor, flat: Tensor, *, k: int = 8) -> Tensor:
    """Return where new rows fall on the map of known ones.

    queries  (Q, D) new features
    points   (N, D) the features that the map was made of, at the same order
    flat     (N, 2) the map; one NaN row leaves its neighbours' places unknown
    k        neighbours to lie between; small sets use all they have
    return   (Q, 2) mean of the neighbours' places, weighted by exp(-(d - nearest) / mean excess)

    A row that is already there falls on its own point. The map itself does not move; a linear
    map (PCA) places new rows exactly with `pca.Basis.place` instead.
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
