"""Means, spreads and confidence intervals of paired differences."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Mean and standard deviation (n - 1) of n values; NaN for too few of them."""

    mean: float
    std: float
    n: int


def spread(values: Sequence[float]) -> Spread:
    """Return mean, standard deviation and n."""
    array, n = np.asarray(values, dtype=float), len(values)
    mean = float(array.mean()) if n else float("nan")
    return Spread(mean=mean, std=float(array.std(ddof=1)) if n > 1 else float("nan"), n=n)


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean paired difference with its confidence interval."""

    mean: float
    low: float
    high: float
