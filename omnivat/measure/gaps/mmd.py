"""Maximum mean discrepancy (MMD) of two sets of features, linear and Gaussian kernel.

Both are the biased estimate, which counts a row with itself: it is above 0 for two samples of one
distribution. Compare it with `omnivat.measure.gaps.domain.floor`.
"""

from collections.abc import Iterator

import torch
from jaxtyping import Float
from torch import Tensor

from omnivat.kit.seeding import derive_seed
from omnivat.kit.shapes import features
from omnivat.measure.gaps.centroid import centroid_gap
from omnivat.measure.gaps.unit import Estimate, unit

BLOCK = 1024  # rows of a kernel matrix held at once
MOST_ROWS = 20_000  # of both sets together, up to which the kernel is summed exactly
GROUPS, FEATURES, SAMPLE = 16, 64, 2048  # of random Fourier features, and of rows, for more


def mmd_linear(a: Float[Tensor, "N D"], b: Float[Tensor, "M D"]) -> Float[Tensor, ""]:
    """Return the squared MMD with the linear kernel, on unit rows: the square of `centroid_gap`.

    Raises ShapeError for sets that are too small or of differing widths.
    Source: Gretton et al., JMLR 13:723-773, 2012.

    >>> import torch
    >>> a, b = torch.eye(2)[[0, 0, 0]], torch.eye(2)[[1, 1]]
    >>> mmd_linear(a, b).round(), mmd_linear(a, a)
    (tensor(2.), tensor(0.))
    """
    return centroid_gap(a, b).square()


def mmd_rbf(a: Float[Tensor, "N D"], b: Float[Tensor, "M D"]) -> Float[Tensor, ""]:
    """Return the squared MMD with the kernel exp(-gamma |x - y|²), on unit rows.

    return  in [0, 2]; 0 for equal sets. Unlike the linear kernel, it compares more than means

    gamma is one over the mean squared distance of two rows of both sets together, which needs no
    kernel matrix and is symmetric in a and b. Costs O((N + M)² D) up to MOST_ROWS rows of both
    together, and holds BLOCK rows of the kernel at once. Beyond, it is estimated by
    `mmd_rbf_estimate`, at a cost that does not depend on N and M. Raises ShapeError for an empty
    set or differing widths. Source: Gretton et al., JMLR 13:723-773, 2012.

    >>> a, b = torch.tensor([[1.0, 0.0]] * 3), torch.tensor([[0.0, 1.0]] * 3)
    >>> round(float(mmd_rbf(a, a)), 3), round(float(mmd_rbf(a, b)), 3)
    (0.0, 1.729)
    """
    a, b = features(a=a, b=b)
    if len(a) + len(b) > MOST_ROWS:
        return mmd_rbf_estimate(a, b).value
    a, b = unit(a), unit(b)
    width = _gamma(a, b, len(a) / (len(a) + len(b)))
    same = _mean_kernel(a, a, width) + _mean_kernel(b, b, width)
    return (same - 2 * _mean_kernel(a, b, width)).clamp_min(0)


def mmd_rbf_estimate(a: Float[Tensor, "N D"], b: Float[Tensor, "M D"]) -> Estimate:
    """Estimate `mmd_rbf` by random Fourier features of random rows, with its standard error.

    return  the mean over GROUPS groups of FEATURES features and at most SAMPLE rows of each set.
            Groups share no rows, so they are independent also where the rows themselves were drawn
            from a larger set, and their spread gives the error. The same in every call

    For a frequency w and S of N rows, m the mean of exp(iwx) over them, (S|m|² - 1) / (S - 1) has
    the mean of (N|φ|² - 1) / (N - 1), where φ is the mean over all rows. At most SAMPLE rows are
    all in each group. Each group has the gamma of its rows. Costs O(D GROUPS FEATURES SAMPLE),
    however many rows there are, and holds SAMPLE rows. Source: Rahimi and Recht, NeurIPS 2007;
    Sutherland and Schneider, UAI 2015.
    """
    a, b = features(a=a, b=b)
    generator = torch.Generator().manual_seed(derive_seed(0, "mmd features"))
    each = []
    for some in zip(_groups(a, generator), _groups(b, generator), strict=True):
        drawn = torch.randn(a.shape[1], FEATURES, generator=generator, dtype=a.dtype)
        waves = drawn.to(a.device) * (2 * _gamma(*some, len(a) / (len(a) + len(b)))).sqrt()
        of_a, square_a = _waves(some[0], waves, len(a))
        of_b, square_b = _waves(some[1], waves, len(b))
        each.append((square_a + square_b - 2 * (of_a * of_b).sum(0)).mean())
    found = torch.stack(each)
    return Estimate(found.mean().clamp_min(0), found.std() / GROUPS**0.5)


def _groups(
    rows: Float[Tensor, "N D"], generator: torch.Generator
) -> Iterator[Float[Tensor, "_ D"]]:
    """Yield GROUPS parts without common rows, each of at most SAMPLE; at most SAMPLE rows as a
    whole.
    """
    size = min(SAMPLE, len(rows) // GROUPS)
    mixed = torch.randperm(len(rows), generator=generator)
    for k in range(GROUPS):
        picked = mixed[k * size : (k + 1) * size].sort().values if len(rows) > SAMPLE else mixed
        yield unit(rows[picked.to(rows.device)])


def _waves(
    rows: Float[Tensor, "S D"], waves: Float[Tensor, "D F"], of: int
) -> tuple[Float[Tensor, "2 F"], Float[Tensor, " F"]]:
    """Return the mean cosine and sine of S of `of` rows along waves, and |φ|²."""
    phase = rows @ waves
    mean = torch.stack([phase.cos().mean(0), phase.sin().mean(0)])
    square, size = mean.square().sum(0), len(rows)
    return mean, square if size == of else (1 + (of - 1) * (size * square - 1) / (size - 1)) / of


def _gamma(a: Float[Tensor, "N D"], b: Float[Tensor, "M D"], share: float) -> Float[Tensor, ""]:
    """Return one over the mean squared distance of two unit rows of both sets; `share` of them is
    a's.
    """
    lengths = share * a.square().sum(1).mean() + (1 - share) * b.square().sum(1).mean()
    mean = share * a.mean(0) + (1 - share) * b.mean(0)
    distance = 2 * (lengths - mean.square().sum())
    tiny = torch.finfo(a.dtype).eps
    return torch.where(distance > tiny, 1 / distance.clamp_min(tiny), torch.ones_like(distance))


def _mean_kernel(
    x: Float[Tensor, "N D"], y: Float[Tensor, "M D"], gamma: Float[Tensor, ""]
) -> Float[Tensor, ""]:
    """Return the mean kernel of all rows of x with all rows of y; for one set, each pair of blocks
    once.
    """

    def summed(rows: Tensor, others: Tensor) -> Tensor:
        lengths = rows.square().sum(1, keepdim=True) + others.square().sum(1)
        return (-gamma * (lengths - 2 * rows @ others.T).clamp_min(0)).exp().sum()

    total = x.new_zeros(())
    for start in range(0, len(x), BLOCK):
        rows = x[start : start + BLOCK]
        if x is y:
            total += summed(rows, rows) + 2 * summed(rows, x[start + BLOCK :])
        else:
            total += summed(rows, y)
    return total / (len(x) * len(y))
