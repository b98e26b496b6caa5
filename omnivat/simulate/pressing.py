"""Press a thing with the sensor of its domain."""

import numpy as np

from omnivat.data.domains import DOMAINS
from omnivat.seeding import derive_seed
from omnivat.simulate.calibrated import calibrated
from omnivat.simulate.contact import Press
from omnivat.simulate.displacement import felt
from omnivat.simulate.noise import Array
from omnivat.simulate.sensors import SENSORS
from omnivat.simulate.tactile import touch
from omnivat.simulate.things import Thing

_TAXIM = {"OF 2.0 A": "Taxim GelSight", "OF 2.0 B": "Taxim GelSight Mini"}


def tactile(thing: Thing, domain: str, stream: int, *, size: int) -> Array:
    """Return TAC (size, size, 3), 0 to 1: the touched spot, imaged by the domain's sensor."""
    press = pressing(np.random.default_rng(derive_seed(stream, "press")))
    noise = derive_seed(stream, "sensor")
    if domain in _TAXIM:
        return calibrated(thing, press, _TAXIM[domain], size=size)
    sensor = DOMAINS[domain].sensor
    if sensor == "Tac3D":
        return felt(thing, press, size=size, seed=noise)
    return touch(thing, press, SENSORS[sensor], size=size, seed=noise)


def pressing(rng: np.random.Generator) -> Press:
    """Draw pose, depth and drag of a press; the sensor is roughly aligned with the object."""
    lean, shear = rng.normal(0, 0.012, 2), rng.normal(0, 0.08, 2)
    return Press(
        turn=float(rng.normal(0, 0.35)),
        lean=(float(lean[0]), float(lean[1])),
        depth=float(rng.uniform(0, 1)),
        shear=(float(shear[0]), float(shear[1])),
    )
