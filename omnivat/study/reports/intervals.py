"""Means, spreads and paired confidence intervals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Mean, standard deviation (n - 1) and number of values."""

    mean: float
    std: float  # NaN for fewer than two values
    n: int

    def scaled(self, by: float) -> "Spread":
        """Return the spread of the values times `by`."""
        return Spread(mean=by * self.mean, std=by * self.std, n=self.n)


def spread(values: Sequence[float]) -> Spread:
    """Return mean, standard deviation and n."""
    array = np.asarray(values, dtype=float)
    mean = float(array.mean()) if len(array) else float("nan")
    return Spread(
        mean=mean, std=float(array.std(ddof=1)) if len(array) > 1 else float("nan"), n=len(array)
    )


def spread_lines(spreads: Sequence[Spread]) -> tuple[list[float], list[float], list[float]]:
    """Return places 0, 1, 2, ..., means and standard deviations, as `omnivat.figures.lines`
    takes them.
    """
    return (
        [float(k) for k in range(len(spreads))],
        [s.mean for s in spreads],
        [s.std for s in spreads],
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Interval:
    """A mean paired difference with its confidence interval and the number of values."""

    mean: float
    low: float
    high: float
    n: int


def t_interval(differences: Sequence[float]) -> Interval:
    """Return Student's 95 % interval for the mean of n paired differences.

    The differences count as independent. The limits are NaN for fewer than two.
    """
    from scipy.stats import t

    found = spread(differences)
    half = (
        float(t.ppf(0.975, found.n - 1)) * found.std / found.n**0.5 if found.n > 1 else float("nan")
    )
    return Interval(mean=found.mean, low=found.mean - half, high=found.mean + half, n=found.n)
