"""Paired bootstrap draws of domains and objects, which all sets and columns of a table share."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings
from omnivat.kit.seeding import derive_seed
from omnivat.study.reports.bootstrap import Resampled

COUNT = 1000  # of draws
LEAST = 3  # domains, from which they are drawn again
Array = NDArray[Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Weights of each pair (1 + B, N) and of each domain (1 + B, D): ones, then the draws."""

    pairs: Array
    domains: Array
    domain: Array  # (N,) of each pair
    sources: list[int]

    def mean(self, values: Array, *, home: bool) -> Resampled:
        """Return the mean over pairs of domains, source and target, of the mean over tested pairs.

        values  (S, N), of each source; NaN for a pair that is not tested
        home    the mean over sources of their own pairs
        """
        return self._over(self._tables(values), home=home)

    def explained(self, squares: Array, truth: Array, *, home: bool) -> Resampled:
        """Return R²: 1 less the mean squared error (S, N) by the variance of numbers (N,)."""
        tested = ~np.isnan(squares)
        numbers = np.where(tested, np.nan_to_num(truth), np.nan)
        first, second = self._tables(numbers), self._tables(numbers**2)
        variance = second - first**2
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(variance > 1e-12, 1 - self._tables(squares) / variance, np.nan)
        return self._over(shares, home=home)

    def _tables(self, values: Array) -> Array:
        """Return (1 + B, S, D) weighted means of each source in each domain."""
        tested = ~np.isnan(values)
        count = self.domains.shape[1]
        found = np.full((len(self.pairs), len(values), count), np.nan)
        for d in range(count):
            own = self.domain == d
            weights = self.pairs[:, own]
            sums = weights @ np.where(tested, values, 0)[:, own].T
            sizes = weights @ tested[:, own].T.astype(float)
            found[:, :, d] = np.where(sizes > 0, sums / np.maximum(sizes, 1), np.nan)
        return found

    def _over(self, tables: Array, *, home: bool) -> Resampled:
        own = np.zeros(tables.shape[1:], bool)
        own[np.arange(len(self.sources)), self.sources] = True
        if home:
            weights = self.domains[:, None, :] * own
        else:
            weights = self.domains[:, self.sources, None] * self.domains[:, None, :] * ~own
        weights = np.where(np.isnan(tables), 0, weights)
        total = weights.sum((1, 2))
        with np.errstate(divide="ignore", invalid="ignore"):
            means = (weights * np.nan_to_num(tables)).sum((1, 2)) / total
        value, draws = float(means[0]), means[1:]
        # a draw of small domains may hold no pair that is tested
        return Resampled(value, np.where(np.isnan(draws), value, draws))


def draws_of(data: Embeddings, sources: list[str]) -> Draws:
    """Draw objects of each domain, and domains where there are LEAST or more."""
    random = np.random.default_rng(derive_seed(0, "comparison"))
    objects, names = data.objects, data.header.domains
    pairs = np.ones((1 + COUNT, len(data)))
    for d in np.unique(data.domain):
        rows = np.flatnonzero(data.domain == d)
        _, own = np.unique(objects[rows], return_inverse=True)
        count = int(own.max()) + 1
        pairs[1:, rows] = random.multinomial(count, np.full(count, 1 / count), COUNT)[:, own]
    there = np.unique(data.domain)
    domains = np.zeros((1 + COUNT, len(names)))
    domains[:, there] = 1
    if len(there) >= LEAST:
        drawn = random.multinomial(len(there), np.full(len(there), 1 / len(there)), 2 * COUNT)
        # one domain alone has no other
        domains[1:, there] = drawn[(drawn > 0).sum(1) > 1][:COUNT]
    return Draws(
        pairs=pairs, domains=domains, domain=data.domain, sources=[names.index(s) for s in sources]
    )
