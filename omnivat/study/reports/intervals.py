"""Means, spreads and confidence intervals of paired differences."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Spread(NamedTuple):
    """Mean and standard deviation (n - 1) of values; NaN for too few of them."""

    mean: float
    std: float


def spread(values: Sequence[float]) -> Spread:
    """Return mean and standard deviation."""
    array, n = np.asarray(values, dtype=float), len(values)
    mean = float(array.mean()) if n else float("nan")
    return Spread(mean=mean, std=float(array.std(ddof=1)) if n > 1 else float("nan"))


class Interval(NamedTuple):
    """A mean paired difference with its confidence interval."""

    mean: float
    low: float
    high: float
