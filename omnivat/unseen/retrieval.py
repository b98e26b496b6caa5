"""Retrieval: is the touch nearest to a photo, in its domain, of the same class?"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.floating[Any]]
BLOCK = 1024  # photos compared at once; bounds the memory
MOST = 2000  # photos of a domain; a larger one is thinned evenly


def judged(keep: NDArray[np.bool_], domain: NDArray[Any], most: int = MOST) -> NDArray[np.int64]:
    """Return the rows for retrieval: at most `most` for each domain, evenly spaced, ascending."""
    chosen = []
    for name in np.unique(domain):
        own = np.flatnonzero(keep & (domain == name))
        if len(own) > most:
            own = own[np.linspace(0, len(own) - 1, most).round().astype(np.int64)]
        chosen.append(own)
    return np.sort(np.concatenate(chosen)) if chosen else np.zeros(0, dtype=np.int64)


def nearest_touch(
    vis: Rows, tac: Rows, domain: NDArray[Any], rows: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return for each of `rows` the row of the touch with the largest cosine in its domain.

    vis     (len(rows), W), photos of `rows`; tac  (N, W); all of any length. A photo's own touch
            may be the nearest
    domain  (N,)
    """
    found = np.zeros(len(rows), dtype=np.int64)
    for name in np.unique(domain[rows]):
        among = np.flatnonzero(domain == name)
        touches = _unit(tac[among])
        places = np.flatnonzero(domain[rows] == name)
        for start in range(0, len(places), BLOCK):
            part = places[start : start + BLOCK]
            found[part] = among[np.argmax(_unit(vis[part]) @ touches.T, axis=1)]
    return found


def _unit(rows: Rows) -> Rows:
    unit: Rows = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12)
    return unit
