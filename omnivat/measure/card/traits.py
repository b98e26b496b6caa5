"""What one touch image shows of its sensor, whatever was touched."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from omnivat.data.dots import Dots, fill_dots
from omnivat.data.relief.filters import SLOW, blurred, reduced, scale
from omnivat.data.relief.lamps import clean

Array = np.ndarray[Any, np.dtype[Any]]
LARGEST = 240  # pixels of the shorter side, to which larger pictures are reduced
FIELD = 14  # cells of the shorter side in which the slow light is kept
# relief between two widths, pixels of 224
FINE, MIDDLE, SOFT, COARSE = (1.0, 1.5), (2.0, 3.0), (1.5, 3.0), (12.0, 24.0)
SHARPEST = 0.999  # quantile of the relief of edges
EXTREME = 5.4  # the same quantile of the mean of three squared normal numbers
DROWNED = 0.1  # of the grain's share in an edge: the least that is told from it
FAINT = 0.05  # of 255: energy below is grain


@dataclass(frozen=True, slots=True)
class Traits:
    """One picture's. Light is in steps of 255.

    size    (width, height) as it came; `filled` (H, W, 3) is reduced, without dots
    field   (h, w, 3): the slow light in cells; tint: its mean (3,)
    noise   standard deviation of the grain
    edge    size of the sharpest edges in relief of FINE over that of MIDDLE, less the grain's
            share; None if grain drowns them
    soft    size of the edges of SOFT, which a strong blur leaves above the grain
    coarse  root mean square of the relief of COARSE
    """

    size: tuple[int, int]
    filled: Array
    dots: Dots | None
    field: Array
    noise: float
    edge: float | None
    soft: float
    coarse: float

    @property
    def tint(self) -> Array:
        """Mean colour (3,)."""
        return np.asarray(self.field.mean((0, 1)))


def traits_of(picture: Array) -> Traits:
    """Return the traits of a touch (H, W, 3) uint8. Raises DataError for another array."""
    height, width, _ = clean(picture, "keep").shape
    small = np.rint(reduced(picture, LARGEST)).astype(np.uint8)
    filled, dots = fill_dots(small)
    light = filled.astype(np.float32)
    grain = grain_of(light)
    field = reduced(blurred(reduced(filled, 112), SLOW / 2), FIELD)
    coarse = float(np.sqrt(max(band(light, COARSE).mean(), FAINT**2)))
    soft = float(np.sqrt(max(edges(light, SOFT, grain)[0], FAINT**2)))
    return Traits((width, height), filled, dots, field, grain, edge_of(light, grain), soft, coarse)


def edge_of(light: Array, grain: float) -> float | None:
    """Return how sharp the sharpest edges of a picture (H, W, C) are, as `Traits` has it."""
    (fine, drowned), (middle, least) = (edges(light, widths, grain) for widths in (FINE, MIDDLE))
    if middle <= max(least, FAINT**2):
        return None
    return float(np.sqrt(max(fine, DROWNED * drowned, FAINT**2) / middle))


def edges(light: Array, widths: tuple[float, float], grain: float) -> tuple[float, float]:
    """Return the energy of the sharpest edges less the grain's share, and that share."""
    share = EXTREME * grain**2 * of_grain(widths, scale(light))
    return float(np.quantile(band(light, widths), SHARPEST)) - share, share


def of_grain(widths: tuple[float, float], unit: float) -> float:
    """Return the energy of white grain of size 1 between two widths, in units of pixels."""
    near, far = (np.square(width * unit) for width in widths)
    return float((1 / near + 1 / far - 4 / (near + far)) / (4 * np.pi))


def grain_of(light: Array) -> float:
    """Return the standard deviation of the grain of a picture (H, W, C): the median of a filter
    that a plane, and nearly an edge, leaves at 0 (Immerkær 1996).
    """
    rows = light[:-2] - 2 * light[1:-1] + light[2:]
    corners = rows[:, :-2] - 2 * rows[:, 1:-1] + rows[:, 2:]
    return float(np.median(np.abs(corners)) / (6 * 0.6745))


def band(light: Array, widths: tuple[float, float]) -> Array:
    """Return the energy (H, W) of a picture's relief between two widths, pixels of 224: the mean
    square over the colours.
    """
    near, far = (blurred(light, width * scale(light)) for width in widths)
    return np.asarray(np.square(near - far).mean(-1))
