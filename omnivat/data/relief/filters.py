"""Gaussians as small matrices, exact to float32 and quick on one core.

All widths are stated in pixels of a picture whose shorter side is 224, and follow a picture's size.
"""

from functools import lru_cache
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]
SIDE = 224  # pixels of the shorter side, to which widths refer
SLOW = 24.0  # width of the slow light: spill of the lamps, tint, dark corners
NODES = 6  # of a wide Gaussian, sampled in each of its widths


def blurred(values: Array, width: float) -> Array:
    """Return values (H, W, C) float32 after a Gaussian of `width` pixels; edges repeat."""
    across, down = _gaussian(values.shape[1], width), _gaussian(values.shape[0], width)
    rows = _applied(down, values)
    return _applied(across, rows.swapaxes(0, 1)).swapaxes(0, 1)


def fast(values: Array) -> Array:
    """Return values (H, W, C) float32 less their slow light."""
    return values - blurred(values, SLOW * scale(values))


def scale(values: Array) -> float:
    """Return the picture's shorter side over 224."""
    return float(min(values.shape[:2]) / SIDE)


def reduced(picture: Array, side: int) -> Array:
    """Return the picture (H, W, C) as float32 means of square blocks: a whole number of pixels,
    so that the shorter side is nearly `side`. What is left over at the end is dropped.
    """
    block = max(1, round(min(picture.shape[:2]) / side))
    height, width = (length // block for length in picture.shape[:2])
    kept = picture[: height * block, : width * block].astype(np.float32)
    rows = kept.reshape(height, block, width * block, -1).sum(1)
    return np.asarray(rows.reshape(height, width, block, -1).sum(2) / np.float32(block**2))


def resized(values: Array, height: int, width: int) -> Array:
    """Return values (h, w, C) float32 interpolated linearly to (height, width, C)."""
    rows = _applied((_linear(values.shape[0], height),), values)
    return _applied((_linear(values.shape[1], width),), rows.swapaxes(0, 1)).swapaxes(0, 1)


def _applied(matrices: tuple[Array, ...], values: Array) -> Array:
    """Return the matrices' product with values (H, ..., C) along the first axis."""
    rows = values.reshape(len(values), -1)
    for matrix in matrices:
        rows = matrix @ rows
    return rows.reshape(len(rows), *values.shape[1:])


@lru_cache(64)
def _gaussian(length: int, width: float) -> tuple[Array, ...]:
    """Return the matrices of a Gaussian: one (length, length), or two through its nodes.

    A wide Gaussian leaves nothing narrow, so its values between nodes are interpolated.
    """
    from scipy.ndimage import gaussian_filter1d

    matrix = gaussian_filter1d(np.eye(length, dtype=np.float32), width, axis=0, mode="nearest")
    nodes = int(np.ceil((length - 1) * NODES / width)) + 1
    if 2 * nodes > length:
        return (matrix,)
    return _linear(length, nodes) @ matrix, _linear(nodes, length)


@lru_cache(64)
def _linear(length: int, wanted: int) -> Array:
    """Return the matrix (wanted, length) that interpolates between the middles of `length` pixels
    and repeats the first and the last.
    """
    place = np.clip((np.arange(wanted) + 0.5) * length / wanted - 0.5, 0, length - 1)
    left = np.minimum(place.astype(int), max(length - 2, 0))
    matrix = np.zeros((wanted, length), np.float32)
    matrix[np.arange(wanted), left] = 1 - (place - left)
    matrix[np.arange(wanted), np.minimum(left + 1, length - 1)] += place - left
    return matrix
