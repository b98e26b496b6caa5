"""A gap between all pairs of domains, and its mean."""

from collections.abc import Callable, Mapping
from itertools import combinations
from typing import Any

import torch
from torch import Tensor

from omnivat.gaps import GAPS
from omnivat.gaps.unit import unit
from omnivat.tables import load

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


def gap_record(
    rows: Mapping[str, Any],
    sets: Mapping[str, Mapping[str, Any]],
    measure: str | Callable[[Any, Any], Tensor],
    check: Callable[[], None] = lambda: None,
) -> dict[str, Any]:
    """Return both gaps of a set by one measure, as plain values.

    rows     "vis", "tac" -> (N, D) unit rows
    sets     modality -> domain with pairs -> its rows
    measure  one of `GAPS`, or a gap of what `rows` and `sets` hold instead of rows
    check    called before each gap; an error it raises ends the work
    return   "modality_gap": domain (or "all") -> value; "domain_gap": modality -> a -> b -> value
    """
    measured = load(GAPS, measure, kind="gap") if isinstance(measure, str) else measure

    def gap(a: Any, b: Any) -> Tensor:
        check()
        found: Tensor = measured(a, b)
        return found

    between = {"all": float(gap(rows["vis"], rows["tac"]))}
    between |= {name: float(gap(one, sets["tac"][name])) for name, one in sets["vis"].items()}
    tables: dict[str, dict[str, dict[str, float]]] = {}
    for modality, some in sets.items():
        tables[modality] = {a: dict.fromkeys(some, 0.0) for a in some}
        for (a, b), value in pairwise_gaps(some, gap).items():
            tables[modality][a][b] = tables[modality][b][a] = float(value)
    return {"modality_gap": between, "domain_gap": tables}
