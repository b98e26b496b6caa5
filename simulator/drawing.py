"""Draw one planned pair: one thing, photographed, and pressed at the same place by its sensor.

Taxim draws the touches of the OF 2.0 domains, through its packaged calibrations.
Source: Si and Yuan, Taxim: An example-based simulation model for GelSight tactile sensors, 2022."""

from functools import lru_cache
from typing import Any

import numpy as np
from PIL import Image

from omnivat.data.tac3d import MARKERS
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import need
from simulator.contact import Press, coloured, displacements, pressed_height
from simulator.noise import Array, Rng
from simulator.photograph import Renderer, photograph
from simulator.plan import Planned
from simulator.sensors import Sensor, SensorModel, TaximSensor
from simulator.tactile import at_rest, touch
from simulator.things import Thing, thing

DEPTH = (0.7, 1.4)  # mm
_PIXEL = 0.0295 * 2  # mm, half of the calibrated resolution of 640 × 480
_HEIGHT, _WIDTH = 240, 320  # pixels, of which the central square is kept
_SQUARE = slice((_WIDTH - _HEIGHT) // 2, (_WIDTH + _HEIGHT) // 2)


@lru_cache(maxsize=2)
def _simulator(calibration: str) -> Any:
    taxim = need("taxim", purpose="tactile images of the OF 2.0 domains", install="taxim jax")
    need("jax", purpose="running taxim on a CPU")
    folder = getattr(taxim, calibration)
    return taxim.Taxim(calib_folder=folder, backend="jax", device="cpu")


def calibrated(thing: Thing, press: Press, calibration: str, *, size: int) -> Array:
    """Return the image (size, size, 3), 0 to 1, that Taxim gives with one of its calibrations.

    Raises MissingPackageError without taxim and jax.
    """
    square = pressed_height(thing, press, field=_WIDTH * _PIXEL, size=_WIDTH)
    # Taxim measures distance from the gel: the highest point has the smallest.
    return _seen(calibration, -square[_SQUARE], press.depth_in(*DEPTH), size)


def _seen(calibration: str, distance: Array, depth: float | None, size: int) -> Array:
    seen = _simulator(calibration).render(
        distance.astype(np.float32), with_shadow=False, press_depth=depth
    )
    whole = Image.fromarray(
        np.round(np.clip(np.asarray(seen)[:, _SQUARE], 0, 1) * 255).astype(np.uint8)
    )
    small = whole.resize((size, size), Image.Resampling.BICUBIC)
    return np.asarray(small, dtype=np.float64) / 255.0


def drawn(pair: Planned, kind: str, *, seed: int, size: int, renderer: Renderer) -> Array:
    """Return the "vis" or "tac" image of a pair, (size, size, 3) from 0 to 1.

    The same seed gives the same image.
    """
    unmet = pair.twin_of or pair
    made = thing(unmet, seed=seed)
    stream = derive_seed(seed, "pair", unmet.domain, unmet.material, unmet.object)
    if kind == "vis":
        return photograph(made, pair, stream, size=size, renderer=renderer)
    return tactile(made, pair.made.sensor, stream, size=size)


def tactile(thing: Thing, sensor: SensorModel, stream: int, *, size: int) -> Array:
    """Return TAC (size, size, 3), 0 to 1: the touched spot, imaged by a sensor."""
    press = pressing(np.random.default_rng(derive_seed(stream, "press")))
    noise = derive_seed(stream, "sensor")
    if isinstance(sensor, TaximSensor):
        return calibrated(thing, press, sensor.calibration, size=size)
    if isinstance(sensor, Sensor):
        return touch(thing, press, sensor, size=size, seed=noise)
    return coloured(displacements(thing, press, sensor, seed=noise), size=size)


def resting(sensor: SensorModel, *, size: int) -> Array:
    """Return the no-contact picture (size, size, 3), 0 to 1, of a sensor: nothing touches it."""
    if isinstance(sensor, TaximSensor):
        # nothing within a metre
        return _seen(sensor.calibration, np.full((_HEIGHT, _WIDTH), 1000.0), None, size)
    if isinstance(sensor, Sensor):
        return at_rest(sensor, size=size)
    return coloured(np.zeros((MARKERS, MARKERS, 3)), size=size)


def pressing(rng: Rng) -> Press:
    """Draw pose, depth and drag of a press; the sensor is roughly aligned with the object."""
    lean, shear = rng.normal(0, 0.012, 2).tolist(), rng.normal(0, 0.08, 2).tolist()
    return Press(turn=rng.normal(0, 0.35), lean=lean, depth=rng.uniform(0, 1), shear=shear)
