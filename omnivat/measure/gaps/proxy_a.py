"""Proxy-A distance: how well a linear classifier separates two sets of features."""

from collections.abc import Iterator

import torch
from jaxtyping import Float, Int
from torch import Tensor

from omnivat.kit.seeding import derive_seed
from omnivat.kit.shapes import require_shapes
from omnivat.measure.gaps.unit import Estimate, require_rows, unit


def proxy_a(
    a: Float[Tensor, "N D"],
    b: Float[Tensor, "M D"],
    *,
    folds: int = 5,
    ridge: float = 1e-2,
    seed: int = 0,
) -> Float[Tensor, ""]:
    """Return 2 (1 - 2 ε), where ε is the out-of-fold error of a linear classifier of a against b.

    a, b    of any length; `folds` rows or more each
    ridge   penalty of the classifier, as a share of the mean variance of a feature
    seed    draws the folds; the same seed gives the same result
    return  in [0, 2]; 0 if the sets cannot be separated, 2 if a hyperplane always separates them

    The classifier is ridge regression on -1 / +1 in closed form, with equal weight for both sets. ε
    is the mean of the two sets' errors; a tie counts half. Errors above one half give 0, because a
    classifier below chance shows no distance. The distance is symmetric in a and b. Raises
    ShapeError for sets that are too small or of differing widths. Source: Ben-David et al., NeurIPS
    2007.

    >>> a, b = torch.tensor([[1.0, 0.1]] * 9), torch.tensor([[0.1, 1.0]] * 9)
    >>> float(proxy_a(a, b)), float(proxy_a(a, a))
    (2.0, 0.0)
    """
    return proxy_a_estimate(a, b, folds=folds, ridge=ridge, seed=seed).value


def proxy_a_estimate(
    a: Float[Tensor, "N D"],
    b: Float[Tensor, "M D"],
    *,
    folds: int = 5,
    ridge: float = 1e-2,
    seed: int = 0,
) -> Estimate:
    """Return `proxy_a` with the standard error of its test rows, which are drawn from larger sets.

    A classifier of fewer rows errs a little more; the standard error does not count that.
    """
    require_shapes(a=(a, "N D"), b=(b, "M D"))
    require_rows(max(folds, 2), a=a, b=b)
    a, b = unit(a), unit(b)
    fold_a, fold_b = (_folds(len(x), folds, seed).to(x.device) for x in (a, b))
    wrong_a, wrong_b = torch.zeros_like(a[:, 0]), torch.zeros_like(b[:, 0])
    for fold, (weight, middle) in enumerate(_fits((a, fold_a), (b, fold_b), folds, ridge)):
        wrong_a[fold_a == fold] = (1 - ((a[fold_a == fold] - middle) @ weight).sign()) / 2
        wrong_b[fold_b == fold] = (1 - ((middle - b[fold_b == fold]) @ weight).sign()) / 2
    error = (wrong_a.mean() + wrong_b.mean()) / 2
    spread = wrong_a.var() / len(a) + wrong_b.var() / len(b)
    return Estimate((2 * (1 - 2 * error)).clamp_min(0), 2 * spread.sqrt())


def _folds(count: int, folds: int, seed: int) -> Int[Tensor, " {count}"]:
    """Return the fold of each row. It depends only on the number of rows, so it is symmetric."""
    generator = torch.Generator().manual_seed(derive_seed(seed, "proxy_a", count))
    return torch.randperm(count, generator=generator) % folds


def _fits(
    first: tuple[Float[Tensor, "N D"], Int[Tensor, " N"]],
    other: tuple[Float[Tensor, "M D"], Int[Tensor, " M"]],
    folds: int,
    ridge: float,
) -> Iterator[tuple[Float[Tensor, " D"], Float[Tensor, " D"]]]:
    """Yield, without each fold, the direction to the first set and the midpoint of means."""
    width, small = first[0].shape[1], len(first[0]) + len(other[0]) < 2 * first[0].shape[1]
    origins = [rows.mean(0) for rows, _ in (first, other)]  # so that products do not cancel
    parts = [
        [rows[fold == k] - at for k in range(folds)]
        for (rows, fold), at in zip((first, other), origins, strict=True)
    ]
    every = torch.cat([p for each in parts for p in each]) if small else first[0]
    cosines = every @ every.T if small else every
    held = torch.cat([torch.full((len(p),), k) for each in parts for k, p in enumerate(each)])
    products = [] if small else [torch.stack([p.T @ p for p in each]) for each in parts]
    sums = [torch.stack([p.sum(0) for p in each]) for each in parts]
    tiny = torch.finfo(first[0].dtype).tiny
    for fold in range(folds):
        kept = [[p for k, p in enumerate(each) if k != fold] for each in parts]
        sizes = [sum(map(len, each)) for each in kept]
        means = [(s.sum(0) - s[fold]) / n for s, n in zip(sums, sizes, strict=True)]
        a, b = (mean + at for mean, at in zip(means, origins, strict=True))
        if small:
            rows = torch.cat(
                [
                    (torch.cat(each) - mean) / n**0.5
                    for each, mean, n in zip(kept, means, sizes, strict=True)
                ]
            )
            index = (held != fold).nonzero()[:, 0].to(rows.device)
            gram = _centred(cosines[index[:, None], index], sizes)
        else:
            covariances = [
                (every.sum(0) - every[fold]) / n - torch.outer(mean, mean)
                for every, n, mean in zip(products, sizes, means, strict=True)
            ]
            gram = covariances[0] + covariances[1]
        penalty = ridge * gram.trace() / width + tiny
        gram.diagonal().add_(penalty)
        if small:
            direction = a - b - rows.T @ torch.linalg.solve(gram, rows @ (a - b))
        else:
            direction = torch.linalg.solve(gram, a - b) * penalty
        yield direction, (a + b) / 2


def _centred(products: Float[Tensor, "N N"], sizes: list[int]) -> Float[Tensor, "N N"]:
    """Return the products of rows less the mean of their set, over the root of its size."""
    for axis in (0, 1):
        sets = products.split(sizes, axis)
        products = torch.cat(
            [(p - p.mean(axis, keepdim=True)) / p.shape[axis] ** 0.5 for p in sets], axis
        )
    return products
