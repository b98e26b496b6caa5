"""Shares of right predictions with 95 % intervals: of one domain, and means over domains.

Pairs of one object are alike, so an interval counts objects. Pairs without an object's name are
objects of their own.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings

Z = 1.959963984540054  # normal quantile of a two-sided 95 % interval
DRAWS = 2000  # of domains and objects
Array = NDArray[Any]
Count = tuple[float, int]  # right and all objects of a domain


def wilson(right: float, total: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, after Wilson (1927); it stays within 0 and 1.

    >>> low, high = wilson(60, 100)
    >>> round(low, 3), round(high, 3)
    (0.502, 0.691)
    """
    share, square = right / total, Z * Z / total
    middle = (share + square / 2) / (1 + square)
    half = Z * np.sqrt(share * (1 - share) / total + square / (4 * total)) / (1 + square)
    return float(max(0.0, middle - half)), float(min(1.0, middle + half))


def of_domains(counts: Sequence[Count]) -> tuple[float, float]:
    """Return the 95 % interval of the mean share over domains: (right, total) of each.

    Bootstrap: domains are drawn with replacement, then objects within each. The interval therefore
    covers other domains of this kind, not only other objects of these domains.
    """
    right, total = map(np.array, zip(*counts, strict=True))
    random = np.random.default_rng(0)
    drawn = random.integers(len(total), size=(DRAWS, len(total)))
    shares = random.binomial(total[drawn], right[drawn] / total[drawn]) / total[drawn]
    low, high = np.quantile(shares.mean(axis=1), [0.025, 0.975])
    return float(low), float(high)


def interval(counts: Sequence[Count]) -> tuple[float, float]:
    """Return the 95 % interval of the mean share over domains: `wilson` for one, else
    `of_domains`.
    """
    return of_domains(counts) if len(counts) > 1 else wilson(*counts[0])


def counted(embeddings: Embeddings, source: str) -> NDArray[np.bool_]:
    """Return a mask (N,) of the test pairs of a head trained on `source`.

    If a domain has a split, its test part counts; otherwise all its pairs do. A source without a
    split has no test pairs, because the head may have been trained on all of them.
    """
    split = np.array(embeddings.rows["split"], dtype=object)
    keep = np.zeros(len(embeddings), dtype=bool)
    for index, name in enumerate(embeddings.header.domains):
        own = embeddings.domain == index
        stated = any(split[own])
        keep |= own & (split == "test") if stated else own & (name != source)
    return keep


def mean_over_domains(
    right: NDArray[Any], embeddings: Embeddings, source: str, keep: NDArray[np.bool_]
) -> float | None:
    """Return the mean over unseen domains of each domain's share of `right` (N,) among `keep`.

    None if the source is not among the domains or no unseen domain has a test pair.
    """
    names, domain = embeddings.header.domains, embeddings.domain
    if source not in names:
        return None
    away = keep & (domain != names.index(source))
    shares = [right[away & (domain == index)].mean() for index in np.unique(domain[away])]
    return float(np.mean(shares)) if shares else None


def record(
    right: Array,
    domain: NDArray[np.int64],
    names: Sequence[str],
    objects: NDArray[np.int64] | None = None,
) -> dict[str, Any]:
    """Return accuracy and interval of right predictions (draws, N); NaN where none was made.

    domain   (N,) indices into `names`
    objects  (N,) the object of each pair; None: each pair is one

    The record: "accuracy", the mean over domains of the share of right pairs, each pair by its mean
    over draws; "low" and "high", its interval; "pairs" that a draw predicted; "domains", the share
    by domain; and "draws", the accuracy of each. Without a prediction the first three are None.
    """
    made = np.asarray(~np.isnan(right).all(axis=0))
    mean = np.where(made, np.nan_to_num(right).sum(0) / np.maximum((~np.isnan(right)).sum(0), 1), 0)
    masks = {names[d]: made & (domain == d) for d in np.unique(domain[made])}
    kinds = np.arange(len(made)) if objects is None else objects
    counts = [_count(mean[rows], kinds[rows]) for rows in masks.values()]
    low, high = interval(counts) if counts else (None, None)
    shares = {name: float(mean[rows].mean()) for name, rows in masks.items()}
    of_draws = [[row[rows] for rows in masks.values()] for row in right]
    each = [[np.nanmean(some) for some in row if not np.isnan(some).all()] for row in of_draws]
    return {
        "accuracy": float(np.mean(list(shares.values()))) if shares else None,
        "low": low,
        "high": high,
        "pairs": int(made.sum()),
        "domains": shares,
        "draws": [float(np.mean(some)) for some in each if some],
    }


def shown(found: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return a record's share with its interval, as pages and figures take it; None without
    pairs.
    """
    if found["accuracy"] is None:
        return None
    return {"share": found["accuracy"], "low": found["low"], "high": found["high"]}


def _count(right: Array, objects: NDArray[np.int64]) -> Count:
    """Return right and all objects of pairs, which are right to a share (n,)."""
    total = len(np.unique(objects))
    return round(float(right.sum())) * total / len(right), total
