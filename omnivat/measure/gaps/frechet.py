"""Fréchet distance of two sets of features, as if each were a Gaussian."""

import torch
from jaxtyping import Float
from torch import Tensor

from omnivat.kit.shapes import features, unit


def frechet(a: Float[Tensor, "N D"], b: Float[Tensor, "M D"]) -> Float[Tensor, ""]:
    """Return the squared Fréchet distance |μa - μb|² + tr(Σa + Σb - 2 (Σa Σb)^½), on unit rows.

    Each set has 2 rows or more, of any length. 0 for equal sets. Covariances divide by N - 1. The
    trace of the root is the sum of the singular values of Ra Rbᵀ, where Ra is the triangular factor
    of the centred rows. No D×D root is needed, and sets smaller than D (singular covariances) are
    exact. Raises ShapeError for sets that are too small or of differing widths. Source: Dowson and
    Landau, J. Multivariate Anal. 12:450-455, 1982.

    >>> import torch
    >>> a, b = torch.tensor([[1.0, 0.0]] * 3), torch.tensor([[0.0, 1.0]] * 3)
    >>> frechet(a, b)
    tensor(2.)
    """
    a, b = features(2, a=a, b=b)
    a, b = unit(a), unit(b)
    return distance(a.mean(0), _root(a), b.mean(0), _root(b))


def distance(
    mean_a: Float[Tensor, " D"],
    root_a: Float[Tensor, "_ D"],
    mean_b: Float[Tensor, " D"],
    root_b: Float[Tensor, "_ D"],
) -> Float[Tensor, ""]:
    """Return the distance of Gaussians with these means and covariances RᵀR of roots R."""
    means = (mean_a - mean_b).square().sum()
    spread = root_a.square().sum() + root_b.square().sum()
    shared: Tensor = torch.linalg.svdvals(root_a @ root_b.T).sum()
    return means + (spread - 2 * shared).clamp_min(0)


def _root(x: Float[Tensor, "N D"]) -> Float[Tensor, "K D"]:
    """Return R, min(N, D) rows, with RᵀR the covariance of the rows of x."""
    centred = (x - x.mean(0)) / (len(x) - 1) ** 0.5
    root: Tensor = torch.linalg.qr(centred, mode="r").R if len(x) > x.shape[1] else centred
    return root
