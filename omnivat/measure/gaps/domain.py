"""A gap between all pairs of domains, between modalities, and between halves of one domain."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import combinations
from statistics import fmean
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from omnivat.kit.errors import ShapeError
from omnivat.kit.progress import checkpoint
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import load
from omnivat.measure.gaps import GAPS

Gap = Callable[[Float[Tensor, "N D"], Float[Tensor, "M D"]], Float[Tensor, ""]]


def pairwise_gaps(
    sets: Mapping[str, Float[Tensor, "_ D"]], gap: Gap
) -> dict[tuple[str, str], Float[Tensor, ""]]:
    """Return gap(a, b) for all pairs of the named sets, in the order of the names."""
    return {(a, b): gap(sets[a], sets[b]) for a, b in combinations(sets, 2)}


def halves(sets: Mapping[str, Float[Tensor, "_ D"]]) -> Iterator[tuple[Tensor, Tensor]]:
    """Yield two random halves of each set; the same sets give the same halves."""
    random = torch.Generator().manual_seed(derive_seed(0, "halves"))
    for rows in sets.values():
        mixed = torch.randperm(len(rows), generator=random).to(rows.device)
        first, second = mixed.tensor_split(2)
        yield rows[first], rows[second]


def floor(parts: Iterable[tuple[Any, Any]], gap: Callable[[Any, Any], Tensor]) -> float | None:
    """Return the mean gap between two halves of one domain; None if all are too small.

    No gap starts at 0: samples differ by chance. A gap between domains counts above this level.
    """
    values = []
    for first, second in parts:
        try:
            values.append(float(gap(first, second)))
        except ShapeError:  # too few rows for this measure
            continue
    return fmean(values) if values else None


def gap_record(
    rows: Mapping[str, Any],
    sets: Mapping[str, Mapping[str, Any]],
    measure: str | Callable[[Any, Any], Tensor],
    parts: Mapping[str, Iterable[tuple[Any, Any]]] | None = None,
) -> dict[str, Any]:
    """Return both gaps of a set by one measure, as plain values, and the level of no gap.

    rows     "vis", "tac" -> (N, D) unit rows
    sets     modality -> domain with pairs -> its rows
    measure  one of `GAPS`, or a gap of what `rows` and `sets` hold instead of rows
    parts    modality -> two halves of each domain; None: halves of `sets`
    return   "modality_gap": domain (or "all") -> value; "domain_gap": modality -> a -> b -> value;
             "floor": modality -> `floor` of its domains

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
    between |= {name: float(gap(vis, sets["tac"][name])) for name, vis in sets["vis"].items()}
    tables: dict[str, dict[str, dict[str, float]]] = {}
    for modality, some in sets.items():
        tables[modality] = {a: dict.fromkeys(some, 0.0) for a in some}
        for (a, b), value in pairwise_gaps(some, gap).items():
            tables[modality][a][b] = tables[modality][b][a] = float(value)
    parts = parts or {modality: halves(some) for modality, some in sets.items()}
    floors = {modality: floor(pairs, gap) for modality, pairs in parts.items()}
    return {"modality_gap": between, "domain_gap": tables, "floor": floors}
