"""Means, spreads and paired confidence intervals."""

from collections.abc import Mapping, Sequence
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


def spread_lines(found: Sequence[Spread]) -> tuple[list[float], list[float], list[float]]:
    """Return places 0, 1, 2, ..., means and standard deviations, as `omnivat.figures.lines`
    takes them.
    """
    return [float(k) for k in range(len(found))], [s.mean for s in found], [s.std for s in found]


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


def bootstrap_interval(
    differences: Mapping[str, Sequence[float]], *, draws: int = 10_000
) -> Interval:
    """Return a 95 % percentile interval that resamples groups, then values within each group.

    differences  group (a source) -> its paired differences (seeds). Seeds of one source share its
                 data and are not independent, so whole groups are drawn
    return       mean of the groups' means; n counts all values
    """
    random = np.random.default_rng(0)
    groups = [np.asarray(values, dtype=float) for values in differences.values()]
    total = sum(map(len, groups))
    centre = float(np.mean([values.mean() for values in groups])) if groups else float("nan")
    if len(groups) < 2:
        return Interval(mean=centre, low=float("nan"), high=float("nan"), n=total)
    # means of resampled seeds, for every group
    resampled = np.stack(
        [random.choice(values, (draws, len(values))).mean(1) for values in groups], axis=1
    )
    chosen = random.integers(len(groups), size=(draws, len(groups)))
    means = np.take_along_axis(resampled, chosen, axis=1).mean(1)
    low, high = np.quantile(means, [0.025, 0.975])
    return Interval(mean=centre, low=float(low), high=float(high), n=total)


def paired_differences(
    ours: Mapping[tuple[str, int], float], theirs: Mapping[tuple[str, int], float]
) -> dict[str, list[float]]:
    """Return ours - theirs by source, for every (source, seed) of both."""
    found: dict[str, list[float]] = {}
    for (source, seed), value in ours.items():
        if (source, seed) in theirs:
            found.setdefault(source, []).append(value - theirs[source, seed])
    return found
