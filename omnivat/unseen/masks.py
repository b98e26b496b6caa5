"""Masks of the test pairs of a head."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings

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


def unseen_domains(embeddings: Embeddings, source: str) -> tuple[str, ...]:
    """Return the unseen domains of a head trained on `source`."""
    return tuple(name for name in embeddings.header.domains if name != source)


def mean_over_domains(
    right: NDArray[Any], embeddings: Embeddings, source: str, keep: Mask
) -> float | None:
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
