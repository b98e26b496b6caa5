"""Tac3D: 20 × 20 markers with three-dimensional displacements, shown as a colour image.

The paper does not say how it turns the sensor's vectors into an image. Ours, as the reader of real
files has it (`omnivat.data.tac3d`): (dx, dy, dz) become (red, green, blue), mid-grey is no
displacement, one scale in the skin and one into it for the whole domain, then bicubic. The reader
measures its scales; here they are fixed, so that an image does not depend on how many were made,
and rounded to bytes before the bicubic step, which the shipped features rest on.
"""

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

from omnivat.simulate.contact import Press, draped, indentation, pressed_height
from omnivat.simulate.noise import Array
from omnivat.simulate.surfaces import Surface

MARKERS = 20
FIELD = 16.0  # mm across the markers
DEPTH = (0.45, 0.9)  # mm
# mm of displacement that reach full colour. 99 % of the shipped set's displacements lie under 0.16 in
# the skin and 0.83 into it: the deepest presses are cut to full blue.
LATERAL, NORMAL = 0.16, 0.55
_GRID = 160  # points on which the gel is draped before it is read at the markers


def displacements(surface: Surface, press: Press, *, seed: int) -> Array:
    """Return the markers' displacements (20, 20, 3) in mm: right, up, and into the sensor."""
    height = pressed_height(surface, press, field=FIELD, size=_GRID)
    depth = DEPTH[0] + press.depth * (DEPTH[1] - DEPTH[0])
    indent = indentation(height, field=FIELD, depth=depth, dome=0.25)
    sheet = draped(indent, field=FIELD, give=0.8, skin=0.22)
    pixel = FIELD / _GRID
    down, right = np.gradient(sheet, pixel)
    held = gaussian_filter(sheet, 1.0 / pixel, mode="nearest")
    held = held / max(float(held.max()), 1e-6)
    field = np.stack(
        [-0.22 * right + press.shear[0] * held, 0.22 * down + press.shear[1] * held, sheet], axis=-1
    )
    step = _GRID // MARKERS
    read = field[step // 2 :: step, step // 2 :: step]
    return read + np.random.default_rng(seed).normal(size=read.shape) * 0.006


def coloured(displacement: Array, *, size: int) -> Array:
    """Return the image (size, size, 3), 0 to 1, of a displacement field (20, 20, 3) in mm."""
    scaled = displacement / np.array([LATERAL, LATERAL, NORMAL])
    bytes_ = np.clip(127.5 + 127.5 * scaled, 0, 255).astype(np.uint8)
    large = Image.fromarray(bytes_).resize((size, size), Image.Resampling.BICUBIC)
    return np.asarray(large, dtype=np.float64) / 255.0


def felt(surface: Surface, press: Press, *, size: int, seed: int) -> Array:
    """Return the Tac3D image (size, size, 3), 0 to 1, of one press."""
    return coloured(displacements(surface, press, seed=seed), size=size)
