"""Gaps of sets too large for memory: exact from moments, or estimated from random pairs."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property

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


class Moments:
    """Number, mean and, with `squares`, covariance of unit rows, in double precision.

    Products of a block are in the rows' precision. They are taken about the first block's mean, so
    nothing cancels.
    """

    def __init__(self, rows: Float[Tensor, "B W"], *, squares: bool = False) -> None:
        self.origin = rows.double().mean(0)
        self.count, self.sum = 0, torch.zeros_like(self.origin)
        self.products = self.sum.new_zeros(2 * (len(self.sum),)) if squares else None
        self.add(rows)

    def add(self, rows: Float[Tensor, "B W"]) -> None:
        rows = rows - self.origin.to(rows)
        self.count += len(rows)
        self.sum += rows.sum(0, dtype=torch.float64)
        if self.products is not None:
            self.products += rows.T @ rows

    @property
    def mean(self) -> Float64[Tensor, " W"]:
        return self.origin + self.sum / self.count

    @cached_property
    def root(self) -> Float64[Tensor, "W W"]:
        """R with RᵀR the covariance."""
        assert self.products is not None
        spread = self.products - torch.outer(self.sum, self.sum) / self.count
        values, axes = torch.linalg.eigh(spread / max(1, self.count - 1))
        root: Tensor = values.clamp_min(0).sqrt()[:, None] * axes.T
        return root

    @classmethod
    def joined(cls, parts: Sequence["Moments"]) -> "Moments":
        """Return the moments of several sets together."""
        whole = cls.__new__(cls)
        whole.origin, whole.count = parts[0].origin, sum(one.count for one in parts)
        moves = [one.origin - whole.origin for one in parts]
        whole.sum = sum(
            (one.sum + one.count * move for one, move in zip(parts, moves, strict=True)),
            torch.zeros_like(whole.origin),
        )
        whole.products = None
        if parts[0].products is not None:
            whole.products = torch.zeros_like(parts[0].products)
            for one, move in zip(parts, moves, strict=True):
                assert one.products is not None
                cross = torch.outer(one.sum, move)
                whole.products += one.products + cross + cross.T
                whole.products += one.count * torch.outer(move, move)
        return whole


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
    found: dict[str, dict[int, Moments]] = {"vis": {}, "tac": {}}
    random = np.random.default_rng(derive_seed(0, "halves"))
    half = 2 * domain + random.integers(2, size=len(domain))
    for some, features in blocks:
        own = half[some]
        for index in np.unique(own).tolist():
            members = torch.from_numpy(np.flatnonzero(own == index))
            for name, into in found.items():
                rows = features[name][members.to(features[name].device)]
                if index in into:
                    into[index].add(rows)
                else:
                    into[index] = Moments(rows, squares=squares)
    both = {
        name: {k: [own[h] for h in (2 * k, 2 * k + 1) if h in own] for k in np.unique(domain)}
        for name, own in found.items()
    }
    sets = {m: {names[k]: Moments.joined(own) for k, own in of.items()} for m, of in both.items()}
    halves = {
        m: [(own[0], own[-1]) for own in of.values() if len(own) > 1] for m, of in both.items()
    }
    return sets, {m: Moments.joined(list(own.values())) for m, own in sets.items()}, halves


def drawn(
    domain: Index, *, seed: int = 0
) -> tuple[Int64[np.ndarray, " M"], Int64[np.ndarray, " S"]]:
    """Draw pairs of each domain; return their rows by domain, and which represent the whole set.

    A domain with at most DRAWN / domains (or LEAST) pairs is whole; the second result holds the
    same share of each domain.
    """
    random = np.random.default_rng(derive_seed(seed, "drawn pairs"))
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
    alike: Int64[np.ndarray, " S"] | None = None,
) -> tuple[Sets, dict[str, Float[Tensor, "_ W"]]]:
    """Return modality -> domain -> rows, and modality -> the rows that represent the set.

    points  VIS, then TAC
    alike   of `drawn`; None: all rows
    """
    each = dict(zip(("vis", "tac"), points.chunk(2), strict=True))
    members = {names[k]: np.flatnonzero(domain == k) for k in np.unique(domain).tolist()}
    sets = {name: {n: _of(rows, own) for n, own in members.items()} for name, rows in each.items()}
    if alike is None:
        return sets, each
    return sets, {name: _of(rows, alike) for name, rows in each.items()}


def _of(rows: Float[Tensor, "_ W"], index: Index) -> Float[Tensor, "_ W"]:
    """Return some rows, ascending; without a copy if they lie together."""
    start, stop = int(index[0]), int(index[-1]) + 1
    return rows[start:stop] if stop - start == len(index) else rows[torch.from_numpy(index)]
