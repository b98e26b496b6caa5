"""Test pairs of a head, and 95 % intervals of shares over them: of one domain, and over domains."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings

Z = 1.959963984540054  # normal quantile of a two-sided 95 % interval
DRAWS = 2000


def wilson(right: float, total: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, after Wilson (1927); it stays within 0 and 1.

    >>> low, high = wilson(60, 100)
    >>> round(low, 3), round(high, 3)
    (0.502, 0.691)
    """
    if total < 1:
        return 0.0, 1.0
    share, square = right / total, Z * Z / total
    middle = (share + square / 2) / (1 + square)
    half = Z * np.sqrt(share * (1 - share) / total + square / (4 * total)) / (1 + square)
    return float(max(0.0, middle - half)), float(min(1.0, middle + half))


def of_domains(counts: Sequence[tuple[int, int]], *, seed: int = 0) -> tuple[float, float]:
    """Return the 95 % interval of the mean share over domains: (right, total) of each.

    Bootstrap: domains are drawn with replacement, then pairs within each. The interval therefore
    covers other domains of this kind, not only other pairs of these domains.
    """
    right, total = (np.array(part, dtype=np.int64) for part in zip(*counts, strict=True))
    random = np.random.default_rng(seed)
    drawn = random.integers(len(total), size=(DRAWS, len(total)))
    shares = random.binomial(total[drawn], right[drawn] / total[drawn]) / total[drawn]
    low, high = np.quantile(shares.mean(axis=1), [0.025, 0.975])
    return float(low), float(high)


Mask = NDArray[np.bool_]


def counted(embeddings: Embeddings, source: str) -> Mask:
    """Return a mask (N,) of the test pairs of a head trained on `source`.

    If a domain has a split, its test part counts; otherwise all its pairs do. A source without a
    split has no test pairs, because the head may have been trained on all of them.
    """
    split = np.array(embeddings.rows.get("split") or [""] * len(embeddings), dtype=object)
    keep = np.zeros(len(embeddings), dtype=bool)
    for index, name in enumerate(embeddings.header.domains):
        own = embeddings.domain == index
        stated = any(split[own])
        keep |= own & (split == "test") if stated else own & (name != source)
    return keep


def mean_over_domains(right: NDArray[Any], embeddings: Embeddings, source: str, keep: Mask) -> float | None:
    """Return the mean over unseen domains of each domain's share of `right` (N,) among `keep`.

    None if the source is not among the domains or no unseen domain has a test pair.
    """
    if source not in embeddings.header.domains:
        return None
    shares = [
        right[own].mean()
        for index, name in enumerate(embeddings.header.domains)
        if name != source and (own := keep & (embeddings.domain == index)).any()
    ]
    return float(np.mean(shares)) if shares else None
