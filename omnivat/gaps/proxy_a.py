"""Proxy-A distance: how well a linear classifier separates two sets of features."""

import torch
from torch import Tensor

from omnivat.gaps.unit import require_rows, unit
from omnivat.seeding import derive_seed
from omnivat.shapes import require_shapes


def proxy_a(a: Tensor, b: Tensor, *, folds: int = 5, ridge: float = 1e-2, seed: int = 0) -> Tensor:
    """Return 2 (1 - 2 ε), where ε is the out-of-fold error of a linear classifier of a against b.

    a, b    (N, D), (M, D) features, any length; `folds` rows or more each
    ridge   penalty of the classifier, as a share of the mean variance of a feature
    seed    draws the folds; the same seed gives the same result
    return  () in [0, 2]; 0 if the sets cannot be separated, 2 if a hyperplane always separates them

    The classifier is ridge regression on -1 / +1 in closed form, with equal weight for both sets.
    ε is the mean of the two sets' errors; a tie counts half. Errors above one half give 0, because
    a classifier below chance shows no distance. The distance is symmetric in a and b. Raises
    ShapeError for sets that are too small or of differing widths. Source: Ben-David et al.,
    NeurIPS 2007.
    """
    require_shapes(a=(a, "N D"), b=(b, "M D"))
    require_rows(max(folds, 2), a=a, b=b)
    a, b = unit(a), unit(b)
    fold_a, fold_b = (_folds(len(x), folds, seed).to(x.device) for x in (a, b))
    wrong_a, wrong_b = torch.zeros_like(a[:, 0]), torch.zeros_like(b[:, 0])
    for fold in range(folds):
        weight, middle = _fit(a[fold_a != fold], b[fold_b != fold], ridge)
        wrong_a[fold_a == fold] = _wrong((a[fold_a == fold] - middle) @ weight)
        wrong_b[fold_b == fold] = _wrong((middle - b[fold_b == fold]) @ weight)
    error = (wrong_a.mean() + wrong_b.mean()) / 2
    return (2 * (1 - 2 * error)).clamp(0, 2)


def _folds(count: int, folds: int, seed: int) -> Tensor:
    """Return the fold of each row. It depends only on the number of rows, so it is symmetric."""
    generator = torch.Generator().manual_seed(derive_seed(seed, "proxy_a", count))
    return torch.randperm(count, generator=generator) % folds


def _fit(a: Tensor, b: Tensor, ridge: float) -> tuple[Tensor, Tensor]:
    """Return the direction from b to a (D,) and the midpoint of the means (D,)."""
    mean_a, mean_b = a.mean(0), b.mean(0)
    middle = (mean_a + mean_b) / 2
    rows = torch.cat([(a - mean_a) / len(a) ** 0.5, (b - mean_b) / len(b) ** 0.5])
    penalty = ridge * rows.square().sum() / rows.shape[1] + torch.finfo(a.dtype).tiny
    return _solve(rows, penalty, mean_a - mean_b), middle


def _solve(rows: Tensor, penalty: Tensor, target: Tensor) -> Tensor:
    """Return (rowsᵀ rows + penalty I)⁻¹ target · penalty, through the smaller Gram matrix."""
    count, width = rows.shape
    if count >= width:
        gram = rows.T @ rows + penalty * torch.eye(width, dtype=rows.dtype, device=rows.device)
        direct: Tensor = torch.linalg.solve(gram, target)
        return direct * penalty
    gram = rows @ rows.T + penalty * torch.eye(count, dtype=rows.dtype, device=rows.device)
    inner: Tensor = torch.linalg.solve(gram, rows @ target)
    return target - rows.T @ inner


def _wrong(score: Tensor) -> Tensor:
    return (1 - score.sign()) / 2
