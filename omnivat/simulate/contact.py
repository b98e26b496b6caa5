"""Press an object into a gel: contact and deformation."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.simulate.heights import contact_height
from omnivat.simulate.noise import Array, turned
from omnivat.simulate.things import Thing


@dataclass(frozen=True, slots=True, kw_only=True)
class Press:
    """Pose and depth of a sensor at the touched spot."""

    turn: float  # rad about the normal, from the spot's tangent
    lean: tuple[float, float]  # slope of the sensor against the surface, mm a mm
    depth: float  # 0 to 1 of the sensor's range
    shear: tuple[float, float]  # mm that the gel is dragged sideways


def plane(field: float, size: int) -> tuple[Array, Array]:
    """Return x and y (size, size) in mm over a square of `field` mm; y grows upwards."""
    axis = (np.arange(size) + 0.5) / size * field - field / 2
    x, y = np.meshgrid(axis, -axis)
    return x, y


def pressed_height(thing: Thing, press: Press, *, field: float, size: int) -> Array:
    """Return the object's height (size, size) in mm, positive towards the sensor.

    It includes the solid's geometry (curves, edges, rims) and the relief of its touch surface.
    """
    x, y = plane(field, size)
    u, v = turned(x, y, -press.turn)
    relief = thing.touch.relief(u + thing.spot.uv[0], v + thing.spot.uv[1])
    form = contact_height(thing.solid, thing.spot, field=field, size=size, turn=press.turn)
    return np.asarray(relief + form + press.lean[0] * x + press.lean[1] * y)


def indentation(height: Array, *, field: float, depth: float, dome: float) -> Array:
    """Return the indentation (mm) of the undeformed gel; 0 without contact."""
    x, y = plane(field, len(height))
    meeting = height + dome * (1.0 - 2.0 * (x**2 + y**2) / field**2)
    return np.asarray(np.maximum(meeting - np.quantile(meeting, 0.998) + depth, 0.0))


def draped(indent: Array, *, field: float, give: float, skin: float) -> Array:
    """Return the gel's displacement (mm): it follows the object and is drawn down nearby.

    From coarse to fine, the sheet is smoothed and pushed out of the object again, like an elastic
    skin. Finally it is smoothed by its own thickness `skin`.
    """
    pixel = field / len(indent)
    sheet = indent
    for width in (give, give / 2, give / 4, give / 8):
        sheet = np.maximum(indent, gaussian_filter(sheet, width / pixel, mode="nearest"))
    return np.asarray(gaussian_filter(sheet, skin / pixel, mode="nearest"))
