"""Principal components in two or three dimensions: exact, with a fixed sign."""

from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.kit.errors import ShapeError
from omnivat.kit.shapes import SUMMED, features

BLOCK = 16_384  # rows centred at once


@dataclass(frozen=True, slots=True)
class Basis:
    """A linear map to the plane or to space: subtract `mean` (D,), multiply by `axes` (D, 2 or
    3).
    """

    mean: Tensor
    axes: Tensor

    def place(self, points: Tensor) -> Tensor:
        """Return the places (N, 2) of points (N, D), BLOCK rows at a time."""
        return torch.cat([(rows - self.mean) @ self.axes for rows in points.split(BLOCK)])


def project(points: Tensor, *, seed: int = 0, dimensions: int = 2) -> Tensor:
    """Return the PCA map of points (N, D) -> (N, dimensions). PCA is exact: `seed` has no
    effect.

    >>> points = torch.tensor([[0.0, 0.0, 1.0], [3.0, 0.0, 1.0], [-3.0, 1.0, 1.0]])
    >>> tuple(project(points).shape)
    (3, 2)
    """
    (points,) = features(most=SUMMED, points=points)
    return basis(points, dimensions).place(points)


def basis(points: Tensor, dimensions: int = 2) -> Basis:
    """Return the directions of largest variance of points (N, D), largest first.

    The largest entry of each axis by modulus is positive. Computed in float64 from the smaller of
    the covariance and the Gram matrix. A direction without variance is still a unit vector, so a
    map is always (N, dimensions).
    Raises ShapeError for no rows or fewer columns than dimensions, DataError for values that are
    not finite or above SUMMED.
    """
    (points,) = features(most=SUMMED, points=points)
    rows, width = points.shape
    if width < dimensions:
        raise ShapeError(
            f"points has shape {(rows, width)}; a map needs {dimensions} columns or more."
        )
    mean = points.mean(0)
    few = dimensions <= rows < width
    axes = (
        _from_gram(points - mean, dimensions) if few else _from_covariance(points, mean, dimensions)
    )
    largest = axes.gather(0, axes.abs().argmax(0, keepdim=True))
    return Basis(mean, (axes * torch.where(largest < 0, -1, 1)).to(points))


def _from_covariance(points: Tensor, mean: Tensor, dimensions: int) -> Tensor:
    """Return the axes from the covariance, exactly for any number of rows; BLOCK rows are centred
    at a time.
    """
    width = points.shape[1]
    products = torch.zeros(width, width, dtype=torch.float64)
    for rows in points.split(BLOCK):
        centred = (rows - mean).detach().cpu().numpy()
        # numpy computes one half, the other being the same
        products += torch.from_numpy(centred.T @ centred).double()
    vectors: Tensor = torch.linalg.eigh(products).eigenvectors
    return vectors[:, -dimensions:].flip(1)


def _from_gram(centred: Tensor, dimensions: int) -> Tensor:
    """Return the same axes (D, dimensions) from the N×N Gram matrix, if N is less than D."""
    vectors = (
        torch.linalg.eigh((centred @ centred.T).double()).eigenvectors[:, -dimensions:].flip(1)
    )
    axes = centred.double().T @ vectors
    # QR gives unit columns, and a perpendicular one if the rows have no second direction
    turned: Tensor = torch.linalg.qr(axes).Q
    return turned
