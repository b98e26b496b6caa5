"""95 % intervals of shares: of one domain's pairs, and of the mean over domains."""

from collections.abc import Sequence

import numpy as np

Z = 1.959963984540054  # normal quantile of a two-sided 95 % interval
DRAWS = 2000


def wilson(right: int, total: int) -> tuple[float, float]:
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
