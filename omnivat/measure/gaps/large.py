"""Gaps of sets too large for memory: exact from moments, or estimated from random pairs."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import add

import numpy as np
import torch
from jaxtyping import Float, Float64, Int64
from torch import Tensor

from omnivat.kit.seeding import derive_seed
from omnivat.measure.gaps.frechet import distance
from omnivat.measure.gaps.mmd import mmd_rbf_estimate
from omnivat.measure.gaps.proxy_a import proxy_a_estimate
from omnivat.measure.gaps.unit import Estimate

DRAWN, LEAST = 20_000, 4096  # pairs drawn of all domains together, and at least of each
ESTIMATES: dict[str, Callable[..., Estimate]] = {
    "mmd_rbf": mmd_rbf_estimate,
    "proxy_a": proxy_a_estimate,
}
Index = Int64[np.ndarray, " N"]
Sets = dict[str, dict[str, Float[Tensor, "_ W"]]]  # by modality and domain


@dataclass(frozen=True, kw_only=True)
class Moments:
    """Number, sum and sum of products of unit rows less an origin, in double precision.

    Products of a block are in the rows' precision. The origin lies among the rows, so nothing
    cancels; moments of one origin add up.
    """

    origin: Float64[Tensor, " W"]
    count: int
    sum: Float64[Tensor, " W"]
    products: Float64[Tensor, "W W"]  # for covariances; else empty

    @classmethod
    def of(
        cls, rows: Float[Tensor, "B W"], origin: Float64[Tensor, " W"], *, squares: bool
    ) -> "Moments":
        """Return the moments of rows."""
        rows = rows - origin.to(rows)
        total = rows.sum(0, dtype=torch.float64)
        products = (rows.T @ rows).double() if squares else total.new_zeros(0)
        return cls(origin=origin, count=len(rows), sum=total, products=products)

    def __add__(self, other: "Moments") -> "Moments":
        return Moments(
            origin=self.origin,
            count=self.count + other.count,
            sum=self.sum + other.sum,
            products=self.products + other.products,
        )

    @property
    def mean(self) -> Float64[Tensor, " W"]:
        return self.origin + self.sum / self.count

    @cached_property
    def root(self) -> Float64[Tensor, "W W"]:
        """R with RᵀR the covariance."""
        spread = self.products - torch.outer(self.sum, self.sum) / self.count
        values, axes = torch.linalg.eigh(spread / max(1, self.count - 1))
        root: Tensor = values.clamp_min(0).sqrt()[:, None] * axes.T
        return root


MOMENT_GAPS: dict[str, Callable[[Moments, Moments], Tensor]] = {
    "centroid": lambda a, b: (a.mean - b.mean).norm(),
    "mmd_linear": lambda a, b: (a.mean - b.mean).square().sum(),
    "frechet": lambda a, b: distance(a.mean, a.root, b.mean, b.root),
}


def moments_of(
    blocks: Iterable[tuple[slice, Mapping[str, Float[Tensor, "_ W"]]]],
    domain: Index,
    names: Sequence[str],
    *,
    squares: bool,
) -> tuple[
    dict[str, dict[str, Moments]], dict[str, Moments], dict[str, list[tuple[Moments, Moments]]]
]:
    """Return moments of unit rows: modality -> domain -> all, modality -> all rows, modality -> two
    random halves of each domain.

    domain  index of each pair into `names`; blocks cover the pairs in order
    """
    random = np.random.default_rng(derive_seed(0, "halves"))
    half = 2 * domain + random.integers(2, size=len(domain))
    found: dict[str, dict[int, Moments]] = {"vis": {}, "tac": {}}
    for some, features in blocks:
        for name, into in found.items():
            rows = features[name]
            origin = into[min(into)].origin if into else rows.double().mean(0)
            for index in np.unique(half[some]).tolist():
                moments = Moments.of(rows[half[some] == index], origin, squares=squares)
                into[index] = into[index] + moments if index in into else moments
    parts = {
        name: {k: [of[h] for h in (2 * k, 2 * k + 1) if h in of] for k in np.unique(domain)}
        for name, of in found.items()
    }
    sets = {m: {names[k]: reduce(add, own) for k, own in of.items()} for m, of in parts.items()}
    halves = {
        m: [(own[0], own[1]) for own in of.values() if len(own) > 1] for m, of in parts.items()
    }
    return sets, {m: reduce(add, own.values()) for m, own in sets.items()}, halves


def drawn(domain: Index) -> tuple[Int64[np.ndarray, " M"], Int64[np.ndarray, " S"]]:
    """Draw pairs of each domain; return their rows by domain, and which represent the whole set.

    A domain with at most DRAWN / domains (or LEAST) pairs is whole; the second result holds the
    same share of each domain.
    """
    random = np.random.default_rng(derive_seed(0, "drawn pairs"))
    sizes = np.bincount(domain)
    most = max(LEAST, DRAWN // int(np.count_nonzero(sizes)))
    share = min(1.0, most / int(sizes.max()))
    mixed = [random.permutation(np.flatnonzero(domain == k)) for k in np.flatnonzero(sizes)]
    taken = [np.sort(own[:most]) for own in mixed]
    alike = [
        np.isin(rows, own[: round(share * len(own))])
        for rows, own in zip(taken, mixed, strict=True)
    ]
    return np.concatenate(taken), np.flatnonzero(np.concatenate(alike))


def parts_of(
    points: Float[Tensor, "_ W"],
    domain: Index,
    names: Sequence[str],
    alike: Int64[np.ndarray, " S"] | slice = slice(None),
) -> tuple[Sets, dict[str, Float[Tensor, "_ W"]]]:
    """Return modality -> domain -> rows, and modality -> the rows that represent the set.

    points  VIS, then TAC
    alike   of `drawn`; default: all rows
    """
    each = dict(zip(("vis", "tac"), points.chunk(2), strict=True))
    present = np.unique(domain).tolist()
    sets = {name: {names[k]: rows[domain == k] for k in present} for name, rows in each.items()}
    return sets, {name: rows[alike] for name, rows in each.items()}
