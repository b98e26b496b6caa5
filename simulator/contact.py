"""Press an object into a gel: contact and deformation; Tac3D's markers and their picture.

Tac3D has 20 × 20 markers with three-dimensional displacements. Its picture is drawn as for real
files (`omnivat.data.tac3d`): (dx, dy, dz) become (red, green, blue) around mid-grey, on one scale
for the whole domain."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.data.tac3d import MARKERS, field_to_rgb
from simulator.noise import Array, plane, turned
from simulator.sensors import Gel
from simulator.shapes.spots import contact_height
from simulator.things import Thing


@dataclass(frozen=True, slots=True, kw_only=True)
class Press:
    """Pose and depth of a sensor at the touched spot."""

    turn: float  # rad about the normal, from the spot's tangent
    lean: Sequence[float]  # x, y: slope of the sensor against the surface, mm a mm
    depth: float  # 0 to 1 of the sensor's range
    shear: Sequence[float]  # x, y: mm that the gel is dragged sideways

    def depth_in(self, least: float, most: float) -> float:
        """Return the depth in mm within a sensor's range."""
        return least + self.depth * (most - least)


def pressed_height(thing: Thing, press: Press, *, field: float, size: int) -> Array:
    """Return the object's height (size, size) in mm, positive towards the sensor.

    It includes the solid's geometry (curves, edges, rims) and the relief of its touch surface.
    """
    x, y = plane(field, size)
    u, v = turned(x, y, -press.turn)
    relief = thing.touch.relief(u + thing.spot.uv[0], v + thing.spot.uv[1])
    form = contact_height(thing.solid, thing.spot, field=field, size=size, turn=press.turn)
    return relief + form + press.lean[0] * x + press.lean[1] * y


def indentation(height: Array, gel: Gel, depth: float) -> Array:
    """Return the indentation (mm) of the undeformed gel; 0 without contact."""
    x, y = plane(gel.field, len(height))
    meeting = height + gel.dome * (1.0 - 2.0 * (x**2 + y**2) / gel.field**2)
    return np.maximum(meeting - np.quantile(meeting, 0.998) + depth, 0.0)


def draped(indent: Array, gel: Gel) -> Array:
    """Return the gel's displacement (mm): it follows the object and is drawn down nearby.

    From coarse to fine, the sheet is smoothed and pushed out of the object again, like an elastic
    skin. Finally it is smoothed by its own thickness.
    """
    pixel = gel.field / len(indent)
    sheet, give = indent, gel.give
    for width in (give, give / 2, give / 4, give / 8):
        sheet = np.maximum(indent, gaussian_filter(sheet, width / pixel, mode="nearest"))
    return gaussian_filter(sheet, gel.skin / pixel, mode="nearest")


def pressed_gel(thing: Thing, press: Press, gel: Gel, *, size: int) -> Array:
    """Return the displacement (size, size) of a gel in mm, into the sensor."""
    height = pressed_height(thing, press, field=gel.field, size=size)
    return draped(indentation(height, gel, press.depth_in(*gel.depth)), gel)


_BULGE = 0.45  # mm sideways for a slope of 1: the gel moves aside
_DRAG = 0.5  # share of the drag that reaches the markers
# mm for full colour: `robust_scale` of 60 pairs of the shipped set; fixed, so an image does not
# depend on the others
SCALE = np.array([0.14, 0.14, 0.74])
_GRID = 160  # resolution of the gel before sampling at the markers


def displacements(thing: Thing, press: Press, gel: Gel, *, seed: int) -> Array:
    """Return the markers' displacements (20, 20, 3) in mm: right, up, and into the sensor."""
    sheet = pressed_gel(thing, press, gel, size=_GRID)
    pixel = gel.field / _GRID
    down, right = np.gradient(sheet, pixel)
    held = gaussian_filter(sheet, 1.0 / pixel, mode="nearest")
    held = held / max(float(held.max()), 1e-6)
    drag = [_DRAG * along * held for along in press.shear]
    field = np.stack([-_BULGE * right + drag[0], _BULGE * down + drag[1], sheet], axis=-1)
    step = _GRID // MARKERS
    read = field[step // 2 :: step, step // 2 :: step]
    return read + np.random.default_rng(seed).normal(size=read.shape) * 0.004


def coloured(displacement: Array, *, size: int) -> Array:
    """Return the image (size, size, 3), 0 to 1, of a displacement field (20, 20, 3) in mm."""
    return field_to_rgb(displacement, SCALE, side=size).astype(np.float64) / 255.0
