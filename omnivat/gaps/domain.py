"""A gap between all pairs of domains, and its mean."""

from collections.abc import Callable, Mapping
from itertools import combinations

import torch
from torch import Tensor

from omnivat.gaps.unit import unit

Gap = Callable[[Tensor, Tensor], Tensor]


def pairwise_gaps(sets: Mapping[str, Tensor], gap: Gap) -> dict[tuple[str, str], Tensor]:
    """Return gap(a, b) for all pairs of the named sets (N_s, D), in the order of the names."""
    return {(a, b): gap(sets[a], sets[b]) for a, b in combinations(sets, 2)}


def domain_gap(features: Tensor, domains: Tensor) -> Tensor:
    """Mean centroid gap over all pairs of domains.

    features  (N, D) of one modality, any length
    domains   (N,) domain of each row, 0 or more; a domain without rows is left out
    return    () in [0, 2]; NaN for fewer than two domains

    All means are computed at once, in O(N D); `pairwise_gaps` would need S - 1 passes.
    """
    rows = unit(features)
    count = int(domains.max()) + 1 if len(domains) else 1
    sizes = torch.bincount(domains, minlength=count)
    sums = rows.new_zeros(count, rows.shape[1]).index_add_(0, domains, rows)
    means = sums[sizes > 0] / sizes[sizes > 0, None]
    if len(means) < 2:
        return rows.new_tensor(float("nan"))
    first, second = torch.triu_indices(len(means), len(means), 1, device=rows.device)
    gaps: Tensor = (means[first] - means[second]).norm(dim=1)
    return gaps.mean()
