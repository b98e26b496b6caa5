"""Tac3D: 20 × 20 markers with three-dimensional displacements, shown as a colour image.

The picture is drawn as for real Tac3D files (`omnivat.data.tac3d`): (dx, dy, dz) become (red,
green, blue) around mid-grey, on one scale for the whole domain.
"""

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.data.tac3d import MARKERS, field_to_rgb
from omnivat.simulate.contact import Press, draped, indentation, pressed_height
from omnivat.simulate.noise import Array
from omnivat.simulate.things import Thing

FIELD = 16.0  # mm across the markers
DEPTH = (0.4, 0.85)  # mm
_BULGE = 0.45  # mm sideways for a slope of 1: the gel moves aside
_DRAG = 0.5  # share of the drag that reaches the markers
# mm for full colour: `robust_scale` of 60 pairs of the shipped set, fixed here so that an image
# does
# not depend on the number of others.
SCALE = np.array([0.14, 0.14, 0.74])
_GRID = 160  # resolution of the gel before sampling at the markers


def displacements(thing: Thing, press: Press, *, seed: int) -> Array:
    """Return the markers' displacements (20, 20, 3) in mm: right, up, and into the sensor."""
    height = pressed_height(thing, press, field=FIELD, size=_GRID)
    depth = DEPTH[0] + press.depth * (DEPTH[1] - DEPTH[0])
    indent = indentation(height, field=FIELD, depth=depth, dome=0.25)
    sheet = draped(indent, field=FIELD, give=0.8, skin=0.22)
    pixel = FIELD / _GRID
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


def felt(thing: Thing, press: Press, *, size: int, seed: int) -> Array:
    """Return the Tac3D image (size, size, 3), 0 to 1, of one press."""
    return coloured(displacements(thing, press, seed=seed), size=size)
