"""What one touch image shows of its sensor, whatever was touched."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from omnivat.data.dots import Dots, fill_dots
from omnivat.data.relief.filters import SLOW, blurred, reduced, scale

Array = np.ndarray[Any, np.dtype[Any]]
FIELD = 14  # cells of the shorter side in which the slow light is kept
FINE, COARSE = 1.5, 12.0  # widths, pixels of 224: relief between each and its double
SHARPEST = 0.999  # quantile of the fine relief: its edges
PLANE = 0.45 / (4 * np.pi)  # energy of white grain between a Gaussian and its double, times width²
EXTREME = 5.4  # the same quantile of the mean of three squared normal numbers
FAINT = 0.05  # of 255: energy below is grain


@dataclass(frozen=True, slots=True)
class Traits:
    """One picture's. Light is in steps of 255.

    field   (h, w, 3): the slow light in cells; tint: its mean (3,)
    noise   standard deviation of the grain
    fine    size of the sharpest edges, in relief 1.5 to 3 pixels of 224 wide
    coarse  root mean square of the relief 12 to 24 pixels wide; both less the grain's share
    """

    filled: Array
    dots: Dots | None
    field: Array
    noise: float
    fine: float
    coarse: float

    @property
    def tint(self) -> Array:
        """Mean colour (3,)."""
        return np.asarray(self.field.mean((0, 1)))


def traits_of(picture: Array) -> Traits:
    """Return the traits of a touch (H, W, 3) uint8."""
    filled, dots = fill_dots(picture)
    light = filled.astype(np.float32)
    grain = grain_of(light)
    unit = scale(light)
    fine, coarse = (band(light, width * unit) for width in (FINE, COARSE))
    edge = np.quantile(fine, SHARPEST) - PLANE * grain**2 * EXTREME / (FINE * unit) ** 2
    field = reduced(blurred(reduced(filled, 112), SLOW / 2), FIELD)
    levels = (float(np.sqrt(max(one, FAINT**2))) for one in (edge, coarse.mean()))
    return Traits(filled, dots, field, grain, *levels)


def grain_of(light: Array) -> float:
    """Return the standard deviation of the grain of a picture (H, W, C): the median of a filter
    that a plane, and nearly an edge, leaves at 0 (Immerkær 1996).
    """
    rows = light[:-2] - 2 * light[1:-1] + light[2:]
    corners = rows[:, :-2] - 2 * rows[:, 1:-1] + rows[:, 2:]
    return float(np.median(np.abs(corners)) / (6 * 0.6745))


def band(light: Array, width: float) -> Array:
    """Return the energy (H, W) of a picture's relief between a width and its double: the mean
    square over the colours.
    """
    near = blurred(light, width)
    return np.asarray(np.square(near - blurred(light, 2 * width)).mean(-1))
