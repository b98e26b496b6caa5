"""Faithfulness of a map."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from omnivat.kit.seeding import derive_seed
from omnivat.kit.shapes import SUMMED, features, require_shapes

SAMPLE = 1000  # rows sampled from a large map
NEIGHBOURS = 15  # of the trust of a map on the page
TRUST_SAMPLE = 200  # rows that it is taken from

BLOCK = 16_384  # rows processed at once
AT_ONCE = 32  # sampled rows compared with all others at once


@dataclass(frozen=True, slots=True, kw_only=True)
class Quality:
    """Trustworthiness and recall of a map, and half the width of their 95 % intervals.

    rows  number of sampled rows; half widths of 0 mean all rows
    """

    trustworthiness: float
    recall: float
    trustworthiness_error: float
    recall_error: float
    rows: int


def quality(
    points: Tensor, flat: Tensor, *, k: int = NEIGHBOURS, rows: int = SAMPLE, seed: int = 0
) -> Quality:
    """Return the quality of a map, from `rows` of its rows sampled at random.

    points (N, D), flat (N, 2); k below N / 2. Trustworthiness is 1 if every neighbour on the map is
    one of the k nearest in space; a neighbour of rank r > k costs r - k. Recall is the share of the
    k nearest rows in space that are among the k nearest on the map. Each sampled row is compared
    with all N, which costs O(rows N D) instead of O(N² D). The intervals cover the sampling.
    Source: Venna and Kaski, ICANN 2001.
    """
    (points,), (flat,) = features(most=SUMMED, points=points), features(most=SUMMED, flat=flat)
    require_shapes(points=(points, "N D"), flat=(flat, "N C"))
    count = len(points)
    drawn = torch.arange(count)
    if count > rows:
        generator = torch.Generator().manual_seed(derive_seed(seed, "quality"))
        drawn = torch.randperm(count, generator=generator)[:rows]
    in_space, on_map = distances(points), distances(flat)
    costs, shares = [], []
    for some in drawn.to(points.device).split(AT_ONCE):
        far, near = in_space(some), on_map(some)
        place = torch.arange(len(some), device=points.device)
        far[place, some], near[place, some] = -torch.inf, torch.inf
        found = far.gather(1, near.topk(k, largest=False).indices)
        # NumPy counts one row at a time, in the processor's cache: 50 times as fast as torch's sums
        rows_of = zip(far.cpu().numpy(), found.cpu().numpy(), strict=True)
        counts = [[np.count_nonzero(row < value) for value in values] for row, values in rows_of]
        rank = torch.tensor(counts, device=far.device)  # (B, k)
        costs.append((rank - k).clamp_min(0).sum(1))
        shares.append((rank <= k).double().mean(1))
    scale = 2 / (k * (2 * count - 3 * k - 1))
    trust, recalled = 1 - scale * torch.cat(costs).double(), torch.cat(shares)
    half = 0.0 if len(drawn) == count else 1.96 / len(drawn) ** 0.5
    return Quality(
        trustworthiness=float(trust.mean()),
        recall=float(recalled.mean()),
        trustworthiness_error=half * float(trust.std()),
        recall_error=half * float(recalled.std()),
        rows=len(drawn),
    )


def trust(points: Tensor, flat: Tensor) -> float | None:
    """Return the sampled trustworthiness of a map of points (N, D), flat (N, 2); None for few
    points.
    """
    if len(points) <= 4 * NEIGHBOURS:
        return None
    return quality(points, flat, rows=TRUST_SAMPLE).trustworthiness


def distances(points: Tensor) -> Callable[[Tensor], Tensor]:
    """Return a function from indices of rows (B,) to their squared distances to points (N, D), up
    to a constant of each row: (B, N).
    """
    middle = points.mean(0)
    squares = torch.cat([(part - middle).square().sum(1) for part in points.split(BLOCK)])
    # (x - m)·(y - m) = x·(y - m), less what all points share: the points are not copied
    return lambda rows: squares - 2 * ((points[rows] - middle) @ points.T)
