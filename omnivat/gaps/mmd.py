"""Maximum mean discrepancy (MMD) of two sets of features, linear and Gaussian kernel."""

import torch
from torch import Tensor

from omnivat.gaps.unit import require_rows, unit
from omnivat.shapes import require_shapes

BLOCK = 1024  # rows of a kernel matrix held at once


def mmd_linear(a: Tensor, b: Tensor, *, unbiased: bool = False) -> Tensor:
    """Squared MMD with the linear kernel, on unit rows.

    a, b      (N, D), (M, D) features, any length
    unbiased  leave out each row's product with itself. Two samples of one distribution then
              average 0 whatever their sizes, and one value may fall below 0; needs 2 rows or more
    return    () in [0, 4]; biased, it is the square of `centroid_gap`

    Exact in O((N + M) D), without a kernel matrix.
    Raises ShapeError for sets that are too small or of differing widths.
    Source: Gretton et al., JMLR 13:723-773, 2012.
    """
    require_shapes(a=(a, "N D"), b=(b, "M D"))
    require_rows(2 if unbiased else 1, a=a, b=b)
    a, b = unit(a), unit(b)
    if not unbiased:
        return (a.mean(0) - b.mean(0)).square().sum()
    return _others(a) + _others(b) - 2 * (a.mean(0) * b.mean(0)).sum()


def _others(x: Tensor) -> Tensor:
    """Mean product of a row with the other rows of its set."""
    return (x.sum(0).square().sum() - x.square().sum()) / (len(x) * (len(x) - 1))


def mmd_rbf(a: Tensor, b: Tensor, *, gamma: float | None = None) -> Tensor:
    """Squared MMD with the kernel exp(-gamma |x - y|²), on unit rows.

    a, b    (N, D), (M, D) features, any length
    gamma   inverse squared width; left out, one over the mean squared distance of two rows of
            both sets together, which needs no kernel matrix and is the same for (b, a)
    return  () in [0, 2]; 0 for equal sets. Unlike the linear kernel it sees more than the mean

    Costs O((N + M)² D) and holds BLOCK rows of the kernel at once.
    Raises ShapeError for an empty set or differing widths.
    Source: Gretton et al., JMLR 13:723-773, 2012.
    """
    require_shapes(a=(a, "N D"), b=(b, "M D"))
    require_rows(1, a=a, b=b)
    a, b = unit(a), unit(b)
    width = torch.as_tensor(gamma, dtype=a.dtype) if gamma is not None else _gamma(a, b)
    same = _mean_kernel(a, a, width) + _mean_kernel(b, b, width)
    return (same - 2 * _mean_kernel(a, b, width)).clamp_min(0)


def _gamma(a: Tensor, b: Tensor) -> Tensor:
    count = len(a) + len(b)
    lengths = a.square().sum() + b.square().sum()
    mean = (a.sum(0) + b.sum(0)) / count
    distance = 2 * (lengths / count - mean.square().sum())
    tiny = torch.finfo(a.dtype).eps
    return torch.where(distance > tiny, 1 / distance.clamp_min(tiny), torch.ones_like(distance))


def _mean_kernel(x: Tensor, y: Tensor, gamma: Tensor) -> Tensor:
    total = x.new_zeros(())
    squares = y.square().sum(1)
    for start in range(0, len(x), BLOCK):
        rows = x[start : start + BLOCK]
        distance = rows.square().sum(1, keepdim=True) + squares - 2 * rows @ y.T
        total = total + (-gamma * distance.clamp_min(0)).exp().sum()
    return total / (len(x) * len(y))
