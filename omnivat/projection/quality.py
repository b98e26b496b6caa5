"""How faithful a map is, and how far it moves from one order to the next."""

import torch
from torch import Tensor

from omnivat.projection.neighbours import nearest
from omnivat.shapes import require_shapes


def trustworthiness(points: Tensor, flat: Tensor, *, k: int = 15) -> float:
    """Tell how far the k nearest rows on the map are also near in space, in [0, 1].

    points (N, D), flat (N, 2); k below N / 2. 1 when every neighbour on the map is one of the k
    nearest in space; a neighbour of rank r > k costs r - k.
    Source: Venna and Kaski, ICANN 2001.
    """
    require_shapes(points=(points, "N D"), flat=(flat, "N C"))
    count = len(points)
    near = nearest(flat, k).index
    middle = points.mean(0)
    points = points - middle
    squares = points.square().sum(1)
    cost = 0
    for start in range(0, count, 1024):
        rows = slice(start, start + 1024)
        distance = torch.addmm(squares, points[rows], points.T, alpha=-2)
        place = torch.arange(len(distance), device=points.device)
        distance[place, place + start] = -torch.inf  # rank 0 is the row itself
        rank = distance.argsort(1).argsort(1)
        cost += int((rank.gather(1, near[rows]) - k).clamp_min(0).sum())
    return 1 - 2 * cost / (count * k * (2 * count - 3 * k - 1))


def recall(points: Tensor, flat: Tensor, *, k: int = 15) -> float:
    """Return the share of the k nearest rows in space that are among the k nearest on the map.

    points (N, D), flat (N, 2) -> in [0, 1].
    """
    require_shapes(points=(points, "N D"), flat=(flat, "N C"))
    truth, found = nearest(points, k).index, nearest(flat, k).index
    return float((truth[:, :, None] == found[:, None, :]).any(2).float().mean())


def radius(flat: Tensor) -> Tensor:
    """Root mean square distance of a map's points (N, 2) from their mean, ()."""
    centred = flat - flat.mean(0)
    return centred.square().sum(1).mean().sqrt()


def drift(before: Tensor, after: Tensor) -> float:
    """Mean distance that points move from one map (N, 2) to the next, in radii of the first."""
    require_shapes(before=(before, "N C"), after=(after, "N C"))
    return float((after - before).norm(dim=1).mean() / radius(before))
