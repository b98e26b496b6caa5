"""Principal components in two dimensions: exact, with a sign that is always the same."""

from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.errors import ShapeError
from omnivat.shapes import require_shapes

BLOCK = 16_384  # rows centred at once


@dataclass(frozen=True, slots=True)
class Basis:
    """A linear map to the plane: subtract `mean` (D,), multiply by `axes` (D, 2)."""

    mean: Tensor
    axes: Tensor

    def place(self, points: Tensor) -> Tensor:
        """Put points (N, D) on this map, (N, 2); BLOCK of them are held apart at once."""
        return torch.cat([(rows - self.mean) @ self.axes for rows in points.split(BLOCK)])


def project(points: Tensor, *, seed: int = 0) -> Tensor:
    """Return the PCA map of points (N, D) -> (N, 2). `seed` is taken and not used: PCA is exact."""
    return basis(points).place(points)


def basis(points: Tensor) -> Basis:
    """Return the two directions of largest variance of points (N, D), largest first.

    Each axis points so that its entry of largest size is positive. Computed in float64 through
    the smaller of the covariance and the Gram matrix. A direction without variance is a unit
    vector all the same, so that a map is always (N, 2).
    Raises ShapeError for no rows or fewer than 2 columns.
    """
    require_shapes(points=(points, "N D"))
    rows, width = points.shape
    if rows < 1 or width < 2:
        raise ShapeError(
            f"points has shape {(rows, width)}; a map needs 1 row and 2 columns or more."
        )
    mean = points.mean(0)
    axes = _from_gram(points - mean) if 2 <= rows < width else _from_covariance(points, mean)
    largest = axes.gather(0, axes.abs().argmax(0, keepdim=True))
    return Basis(mean, (axes * torch.where(largest < 0, -1, 1)).to(points.dtype))


def _from_covariance(points: Tensor, mean: Tensor) -> Tensor:
    """Exact for any number of rows: BLOCK of them are held apart from the mean at once."""
    width = points.shape[1]
    products = torch.zeros(width, width, dtype=torch.float64, device=points.device)
    for rows in points.split(BLOCK):
        centred = rows - mean
        products += (centred.T @ centred).double()
    vectors: Tensor = torch.linalg.eigh(products).eigenvectors
    return vectors[:, -2:].flip(1)


def _from_gram(centred: Tensor) -> Tensor:
    """Fewer rows than columns: the same axes from the N×N matrix of products."""
    vectors = torch.linalg.eigh((centred @ centred.T).double()).eigenvectors[:, -2:].flip(1)
    axes = centred.double().T @ vectors
    # QR gives unit columns, and a perpendicular one where the rows have no second direction
    turned: Tensor = torch.linalg.qr(axes).Q
    return turned
