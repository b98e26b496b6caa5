"""Principal components in two dimensions: exact, with a fixed sign."""

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
        """Return the places (N, 2) of points (N, D), BLOCK rows at a time."""
        return torch.cat([(rows - self.mean) @ self.axes for rows in points.split(BLOCK)])


def project(points: Tensor, *, seed: int = 0) -> Tensor:
    """Return the PCA map of points (N, D) -> (N, 2). `seed` has no effect: PCA is exact."""
    return basis(points).place(points)


def basis(points: Tensor) -> Basis:
    """Return the two directions of largest variance of points (N, D), largest first.

    The largest entry of each axis by modulus is positive. Computed in float64 from the smaller of
    the covariance and the Gram matrix. A direction without variance is still a unit vector, so a
    map is always (N, 2).
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
    """Exact for any number of rows; BLOCK rows are centred at a time."""
    width = points.shape[1]
    products = torch.zeros(width, width, dtype=torch.float64, device=points.device)
    for rows in points.split(BLOCK):
        products += _product(rows - mean).double()
    vectors: Tensor = torch.linalg.eigh(products).eigenvectors
    return vectors[:, -2:].flip(1)


def _product(rows: Tensor) -> Tensor:
    """Return rowsᵀ rows (D, D); numpy computes one half of it, the other being the same."""
    if rows.device.type != "cpu" or rows.requires_grad:
        return rows.T @ rows
    plain = rows.numpy()
    return torch.from_numpy(plain.T @ plain)


def _from_gram(centred: Tensor) -> Tensor:
    """For fewer rows than columns: the same axes from the N×N Gram matrix."""
    vectors = torch.linalg.eigh((centred @ centred.T).double()).eigenvectors[:, -2:].flip(1)
    axes = centred.double().T @ vectors
    # QR gives unit columns, and a perpendicular one if the rows have no second direction
    turned: Tensor = torch.linalg.qr(axes).Q
    return turned
