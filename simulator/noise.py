"""Random fields over the plane: smooth noise, its octaves, and cells. All in millimetres.

Every field is a function of coordinates, so a camera and a tactile sensor can sample one surface at
their own resolution and position.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates, spline_filter

Array = NDArray[np.float64]
Rng = np.random.Generator
Colour = Array | tuple[float, float, float]  # linear, 0 to 1


def one_of(colours: tuple[Colour, ...], rng: Rng) -> Colour:
    """Draw a colour of a table."""
    return colours[rng.integers(len(colours))]


_CELLS = 512  # period of the noise in wavelengths


def plane(field: float, size: int) -> tuple[Array, Array]:
    """Return x and y (size, size) in mm over a square of `field` mm; y grows upwards."""
    axis = (np.arange(size) + 0.5) / size * field - field / 2
    x, y = np.meshgrid(axis, -axis)
    return x, y


@lru_cache(maxsize=1)
def _table() -> Array:
    """Return spline coefficients of one sheet of white noise, scaled so that noise has unit
    spread.
    """
    white = np.random.default_rng(20_000).normal(0.0, 1.7, (_CELLS, _CELLS))
    return spline_filter(white, order=2, mode="grid-wrap")


def direction(turn: float, rise: float) -> Array:
    """Return the unit vector (3,) that lies `turn` rad from the x axis and rises by `rise` rad."""
    return np.array([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)])


def unit(rows: Array) -> Array:
    """Return rows (..., D) of length one; a row of zeros stays."""
    length: Array = np.linalg.norm(rows, axis=-1, keepdims=True)
    return rows / np.maximum(length, 1e-12)


def noise(x: Array, y: Array, seed: int, *, wavelength: float) -> Array:
    """Return smooth noise of about zero mean and unit spread whose bumps are `wavelength` mm
    apart.
    """
    dx, dy, angle = np.random.default_rng(seed).uniform(0.0, 1.0, 3)
    turn_x, turn_y = turned(x, y, 2 * np.pi * angle)
    scale = 1.0 / wavelength
    points = np.stack([turn_y * scale + dy * _CELLS, turn_x * scale + dx * _CELLS])
    return map_coordinates(_table(), points, order=2, mode="grid-wrap", prefilter=False)


def octaves(
    x: Array, y: Array, seed: int, *, wavelength: float, finest: float, roughness: float = 0.5
) -> Array:
    """Sum noise from `wavelength` down to `finest` mm; each octave is `roughness` times the
    last.
    """
    total = np.zeros(np.broadcast(x, y).shape)
    power, weight, step = 0.0, 1.0, 0
    while wavelength >= finest or step == 0:
        total += weight * noise(x, y, seed + step, wavelength=wavelength)
        power += weight**2
        wavelength, weight, step = wavelength / 2, weight * roughness, step + 1
    return total / np.sqrt(power)


def turned(x: Array, y: Array, angle: float) -> tuple[Array, Array]:
    """Return coordinates along and across a direction that lies `angle` rad from the x axis."""
    cos, sin = np.cos(angle), np.sin(angle)
    return x * cos + y * sin, y * cos - x * sin


def cells(
    x: Array, y: Array, seed: int, *, size: float, jitter: float = 0.9
) -> tuple[Array, Array]:
    """Return distance (mm) to the nearest scattered point and to the border of its cell.

    Each square of `size` mm has one point, moved by `jitter` of the square.
    """
    rng = np.random.default_rng(seed)
    offsets = 0.5 + jitter * (rng.random((64, 64, 2)) - 0.5)
    u, v = x / size, y / size
    column, row = np.floor(u), np.floor(v)
    first = np.full(u.shape, np.inf)
    second = np.full(u.shape, np.inf)
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            point = offsets[(row + j).astype(int) % 64, (column + i).astype(int) % 64]
            away = np.hypot(column + i + point[..., 0] - u, row + j + point[..., 1] - v)
            second = np.minimum(second, np.maximum(first, away))
            first = np.minimum(first, away)
    return first * size, (second - first) * size / 2


def smoothstep(value: Array, low: float, high: float) -> Array:
    """Return 0 below `low`, 1 above `high`, and an S between."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
