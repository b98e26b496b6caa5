"""A gap between all pairs of domains, and between modalities."""

from collections.abc import Callable, Mapping
from itertools import combinations
from typing import Any

from jaxtyping import Float
from torch import Tensor

from omnivat.kit.progress import checkpoint
from omnivat.kit.tables import load
from omnivat.measure.gaps import GAPS

Gap = Callable[[Float[Tensor, "N D"], Float[Tensor, "M D"]], Float[Tensor, ""]]


def pairwise_gaps(
    sets: Mapping[str, Float[Tensor, "_ D"]], gap: Gap
) -> dict[tuple[str, str], Float[Tensor, ""]]:
    """Return gap(a, b) for all pairs of the named sets, in the order of the names."""
    return {(a, b): gap(sets[a], sets[b]) for a, b in combinations(sets, 2)}


def gap_record(
    rows: Mapping[str, Any],
    sets: Mapping[str, Mapping[str, Any]],
    measure: str | Callable[[Any, Any], Tensor],
) -> dict[str, Any]:
    """Return both gaps of a set by one measure, as plain values.

    rows     "vis", "tac" -> (N, D) unit rows
    sets     modality -> domain with pairs -> its rows
    measure  one of `GAPS`, or a gap of what `rows` and `sets` hold instead of rows
    return   "modality_gap": domain (or "all") -> value; "domain_gap": modality -> a -> b -> value

    >>> import torch
    >>> east, north = torch.tensor([[1.0, 0.0]]), torch.tensor([[0.0, 1.0]])
    >>> rows = {"vis": torch.cat([east, north]), "tac": torch.cat([east, east])}
    >>> sets = {"vis": {"A": east, "B": north}, "tac": {"A": east, "B": east}}
    >>> found = gap_record(rows, sets, "centroid")
    >>> {name: round(value, 3) for name, value in found["modality_gap"].items()}
    {'all': 0.707, 'A': 0.0, 'B': 1.414}
    >>> round(found["domain_gap"]["vis"]["A"]["B"], 3), found["domain_gap"]["tac"]["A"]["B"]
    (1.414, 0.0)
    """
    measured = load(GAPS, measure, kind="gap") if isinstance(measure, str) else measure

    def gap(a: Any, b: Any) -> Tensor:
        checkpoint()
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
