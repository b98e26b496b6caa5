"""Maximum mean discrepancy (MMD) of two sets of features, linear and Gaussian kernel."""

from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.gaps.unit import require_rows, unit
from omnivat.seeding import derive_seed
from omnivat.shapes import require_shapes

BLOCK, ACROSS = 1024, 16_384  # rows and columns of a kernel matrix held at once
MOST_ROWS = 20_000  # of both sets together, up to which the kernel is summed exactly
GROUPS, FEATURES = 16, 32  # of random Fourier features, for more rows


def mmd_linear(a: Tensor, b: Tensor, *, unbiased: bool = False) -> Tensor:
    """Squared MMD with the linear kernel, on unit rows.

    a, b      (N, D), (M, D) features, any length
    unbiased  leave out each row's product with itself. The expected value for two samples of one
              distribution is then 0, and a value may be negative; needs 2 rows or more
    return    () in [0, 4]; if biased, the square of `centroid_gap`

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
    gamma   inverse squared width; by default, one over the mean squared distance of two rows of
            both sets together, which needs no kernel matrix and is symmetric in a and b
    return  () in [0, 2]; 0 for equal sets. Unlike the linear kernel, it compares more than means

    Costs O((N + M)² D) up to MOST_ROWS rows of both together, and holds BLOCK² numbers of the kernel
    at once. Beyond, it is estimated by `mmd_rbf_estimate`, at a cost of O((N + M) D).
    Raises ShapeError for an empty set or differing widths.
    Source: Gretton et al., JMLR 13:723-773, 2012.
    """
    require_shapes(a=(a, "N D"), b=(b, "M D"))
    require_rows(1, a=a, b=b)
    if is_estimated(a, b):
        return mmd_rbf_estimate(a, b, gamma=gamma).value
    width = _width(a, b, gamma)
    a, b = unit(a), unit(b)
    same = _mean_kernel(a, a, width) + _mean_kernel(b, b, width)
    return (same - 2 * _mean_kernel(a, b, width)).clamp_min(0)


def is_estimated(a: Tensor, b: Tensor) -> bool:
    """True if `mmd_rbf` of two sets is an estimate."""
    return len(a) + len(b) > MOST_ROWS


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value () and its standard error ()."""

    value: Tensor
    error: Tensor


def mmd_rbf_estimate(
    a: Tensor, b: Tensor, *, gamma: float | None = None, seed: int = 0
) -> Estimate:
    """Estimate `mmd_rbf` by random Fourier features, with its standard error.

    a, b    (N, D), (M, D) features, any length
    return  the mean over GROUPS groups of FEATURES features. Every group is an unbiased estimate,
            so their spread gives the error. The same seed gives the same value

    Costs O((N + M) D GROUPS FEATURES) and holds BLOCK rows of features at once.
    Source: Rahimi and Recht, NeurIPS 2007; Sutherland and Schneider, UAI 2015.
    """
    require_shapes(a=(a, "N D"), b=(b, "M D"))
    require_rows(1, a=a, b=b)
    width = _width(a, b, gamma)
    generator = torch.Generator().manual_seed(derive_seed(seed, "mmd features"))
    drawn = torch.randn(a.shape[1], GROUPS * FEATURES, generator=generator, dtype=a.dtype)
    waves = drawn.to(a.device) * (2 * width).sqrt()
    apart = _mean_waves(a, waves) - _mean_waves(b, waves)  # (2, GROUPS * FEATURES)
    each = apart.square().sum(0).view(GROUPS, FEATURES).mean(1)
    return Estimate(each.mean(), each.std() / GROUPS**0.5)


def _mean_waves(rows: Tensor, waves: Tensor) -> Tensor:
    """Return the mean cosine and sine of unit rows (N, D) along waves (D, F): (2, F)."""
    total = torch.zeros(2, waves.shape[1], dtype=torch.float64, device=rows.device)
    for some in rows.split(BLOCK):
        phase = unit(some) @ waves
        total += torch.stack([phase.cos().sum(0), phase.sin().sum(0)])
    return (total / len(rows)).to(rows.dtype)


def _width(a: Tensor, b: Tensor, gamma: float | None) -> Tensor:
    """Return gamma, or the default of `mmd_rbf` if None."""
    return _gamma(a, b) if gamma is None else torch.as_tensor(gamma, dtype=a.dtype)


def _gamma(a: Tensor, b: Tensor) -> Tensor:
    """One over the mean squared distance of two unit rows of both sets."""
    count = len(a) + len(b)
    lengths, summed = a.new_zeros(()), a.new_zeros(a.shape[1])
    for part in (*a.split(ACROSS), *b.split(ACROSS)):
        rows = unit(part)
        lengths, summed = lengths + rows.square().sum(), summed + rows.sum(0)
    mean = summed / count
    distance = 2 * (lengths / count - mean.square().sum())
    tiny = torch.finfo(a.dtype).eps
    return torch.where(distance > tiny, 1 / distance.clamp_min(tiny), torch.ones_like(distance))


def _mean_kernel(x: Tensor, y: Tensor, gamma: Tensor) -> Tensor:
    """Mean kernel of all rows of x with all rows of y; for one set, each pair of blocks once."""
    total = x.new_zeros(())
    for start in range(0, len(x), BLOCK):
        rows = x[start : start + BLOCK]
        if x is y:
            others = _summed(rows, x[start + BLOCK :], gamma)
            total = total + _summed(rows, rows, gamma) + 2 * others
        else:
            total = total + _summed(rows, y, gamma)
    return total / (len(x) * len(y))


def _summed(x: Tensor, y: Tensor, gamma: Tensor) -> Tensor:
    """Sum of the kernel over all rows of x and all rows of y."""
    total, own = x.new_zeros(()), x.square().sum(1, keepdim=True)
    for others in y.split(ACROSS):
        distance = own + others.square().sum(1) - 2 * x @ others.T
        total = total + (-gamma * distance.clamp_min(0)).exp().sum()
    return total
