"""Tactile images by Taxim, through its packaged GelSight and GelSight Mini calibrations.

Source: Si and Yuan, Taxim: An example-based simulation model for GelSight tactile sensors, 2022.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from PIL import Image

from omnivat.packages import need
from omnivat.simulate.contact import Press, pressed_height
from omnivat.simulate.noise import Array
from omnivat.simulate.things import Thing

CALIBRATIONS = {"Taxim GelSight": "CALIB_GELSIGHT", "Taxim GelSight Mini": "CALIB_GELSIGHT_MINI"}
DEPTH = (0.7, 1.4)  # mm
_PIXEL = 0.0295 * 2  # mm, half of the calibrated resolution of 640 × 480
_HEIGHT = 240  # pixels: central square of 320 × 240
_WIDTH = 320


@lru_cache(maxsize=2)
def _simulator(name: str) -> Any:
    taxim = need("taxim", purpose="tactile images of the OF 2.0 domains", install="taxim jax")
    need("jax", purpose="running taxim on a CPU")
    calibration = getattr(taxim, CALIBRATIONS[name])
    return taxim.Taxim(calib_folder=calibration, backend="jax", device="cpu")


def calibrated(thing: Thing, press: Press, name: str, *, size: int) -> Array:
    """Return the image (size, size, 3), 0 to 1, that Taxim gives with the calibration `name`.

    Raises MissingPackageError without taxim and jax.
    """
    square = pressed_height(thing, press, field=_WIDTH * _PIXEL, size=_WIDTH)
    edge = (_WIDTH - _HEIGHT) // 2
    height = square[edge : edge + _HEIGHT]
    depth = DEPTH[0] + press.depth * (DEPTH[1] - DEPTH[0])
    # Taxim measures distance from the gel: the highest point has the smallest.
    seen = _simulator(name).render(
        (-height).astype(np.float32), with_shadow=False, press_depth=depth
    )
    middle = np.asarray(seen)[:, edge : edge + _HEIGHT]
    whole = Image.fromarray(np.round(np.clip(middle, 0, 1) * 255).astype(np.uint8))
    small = whole.resize((size, size), Image.Resampling.BICUBIC)
    return np.asarray(small, dtype=np.float64) / 255.0
