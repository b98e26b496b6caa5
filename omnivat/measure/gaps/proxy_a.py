"""Proxy-A distance: how well a linear classifier separates two sets of features."""

from collections.abc import Iterator

import torch
from jaxtyping import Float, Int
from torch import Tensor

from omnivat.kit.seeding import derive_seed
from omnivat.kit.shapes import features
from omnivat.measure.gaps.unit import Estimate, unit

FOLDS = 5
RIDGE = 1e-2  # penalty of the classifier, as a share of the mean variance of a feature


def proxy_a(a: Float[Tensor, "N D"], b: Float[Tensor, "M D"]) -> Float[Tensor, ""]:
    """Return 2 (1 - 2 ε), where ε is the out-of-fold error of a linear classifier of a against b.

    a, b    of any length; FOLDS rows or more each
    return  in [0, 2]; 0 if the sets cannot be separated, 2 if a hyperplane always separates them

    The classifier is ridge regression on -1 / +1 in closed form, with equal weight for both sets. ε
    is the mean of the two sets' errors; a tie counts half. Errors above one half give 0, because a
    classifier below chance shows no distance. The distance is symmetric in a and b, and the same in
    every call. Raises ShapeError for sets that are too small or of differing widths. Source:
    Ben-David et al., NeurIPS 2007.

    >>> a, b = torch.tensor([[1.0, 0.1]] * 9), torch.tensor([[0.1, 1.0]] * 9)
    >>> float(proxy_a(a, b)), float(proxy_a(a, a))
    (2.0, 0.0)
    """
    return proxy_a_estimate(a, b).value


def proxy_a_estimate(a: Float[Tensor, "N D"], b: Float[Tensor, "M D"]) -> Estimate:
    """Return `proxy_a` with the standard error of its test rows, which are drawn from larger sets.

    A classifier of fewer rows errs a little more; the standard error does not count that.
    """
    a, b = features(FOLDS, a=a, b=b)
    a, b = unit(a), unit(b)
    width = a.shape[1]
    if len(a) + len(b) < width:  # the same classifier, in coordinates of the rows' own span
        span = torch.linalg.qr(torch.cat([a, b]).T).Q
        a, b = a @ span, b @ span
    wrong_a, wrong_b = wrong(a, b, width)
    error = (wrong_a.mean() + wrong_b.mean()) / 2
    spread = wrong_a.var() / len(a) + wrong_b.var() / len(b)
    return Estimate((2 * (1 - 2 * error)).clamp_min(0), 2 * spread.sqrt())


def wrong(
    a: Float[Tensor, "N W"], b: Float[Tensor, "M W"], width: int
) -> tuple[Float[Tensor, " N"], Float[Tensor, " M"]]:
    """Return 1 for a row that a classifier of the other folds takes for the other set's, else 0.

    width  of the features; W, where they have fewer coordinates
    """
    fold_a, fold_b = _folds(a), _folds(b)
    wrong_a, wrong_b = torch.zeros_like(a[:, 0]), torch.zeros_like(b[:, 0])
    for k, (weight, middle) in enumerate(fits((a, fold_a), (b, fold_b), width=width)):
        wrong_a[fold_a == k] = (1 - ((a[fold_a == k] - middle) @ weight).sign()) / 2
        wrong_b[fold_b == k] = (1 - ((middle - b[fold_b == k]) @ weight).sign()) / 2
    return wrong_a, wrong_b


def _folds(rows: Float[Tensor, "N W"]) -> Int[Tensor, " N"]:
    """Return the fold of each row. It depends only on the number of rows, so it is symmetric."""
    generator = torch.Generator().manual_seed(derive_seed(0, "proxy_a", len(rows)))
    return (torch.randperm(len(rows), generator=generator) % FOLDS).to(rows.device)


def fits(
    *sets: tuple[Float[Tensor, "_ W"], Int[Tensor, " _"]], width: int
) -> Iterator[tuple[Float[Tensor, " W"], Float[Tensor, " W"]]]:
    """Yield, without each fold, the direction to the first set and the midpoint of means.

    sets  two of rows and their folds
    """
    origins = [rows.mean(0) for rows, _ in sets]  # so that products do not cancel
    near = [rows - origin for (rows, _), origin in zip(sets, origins, strict=True)]
    products = [rows.T @ rows for rows in near]
    for k in range(FOLDS):
        means, spread = [], torch.zeros_like(products[0])
        for rows, (_, fold), origin, every in zip(near, sets, origins, products, strict=True):
            out = rows[fold == k]
            count = len(rows) - len(out)
            mean = (rows.sum(0) - out.sum(0)) / count
            means.append(origin + mean)
            spread += (every - out.T @ out) / count - torch.outer(mean, mean)
        penalty = RIDGE * spread.trace() / width + torch.finfo(spread.dtype).tiny
        spread.diagonal().add_(penalty)
        apart = means[0] - means[1]
        yield torch.linalg.solve(spread, apart) * penalty, (means[0] + means[1]) / 2
