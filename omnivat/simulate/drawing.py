"""Draw one planned pair: its surface once, photographed and pressed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from omnivat.data.domains import DOMAINS
from omnivat.seeding import derive_seed
from omnivat.simulate.calibrated import calibrated
from omnivat.simulate.camera import exposed
from omnivat.simulate.contact import Press
from omnivat.simulate.displacement import felt
from omnivat.simulate.framing import Framing, framed
from omnivat.simulate.noise import Array
from omnivat.simulate.plan import Planned
from omnivat.simulate.scenes import SCENES
from omnivat.simulate.sensors import SENSORS
from omnivat.simulate.shading import shaded
from omnivat.simulate.surfaces import Surface, surface
from omnivat.simulate.tactile import touch

Renderer = Callable[..., Array]
_TAXIM = {"OF 2.0 A": "Taxim GelSight", "OF 2.0 B": "Taxim GelSight Mini"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """The two images of one pair, (size, size, 3) from 0 to 1."""

    vis: Array
    tac: Array


def drawn(pair: Planned, *, seed: int, size: int, renderer: Renderer = shaded) -> Drawn:
    """Return both images of `pair`; the same seed gives the same images."""
    thing = surface(pair.material, pair.number, seed=seed)
    stream = derive_seed(seed, "pair", pair.domain, pair.material, pair.object)
    press = pressing(np.random.default_rng(stream), thing)
    return Drawn(
        vis=photograph(thing, press, pair, stream, size=size, renderer=renderer),
        tac=tactile(thing, press, pair.domain, stream, size=size),
    )


def photograph(
    thing: Surface, press: Press, pair: Planned, stream: int, *, size: int, renderer: Renderer
) -> Array:
    """Return VIS: the surface around the contact, as the domain's camera takes it."""
    scene = SCENES[pair.domain]
    framing: Framing = framed(
        scene, thing, at=press.at, part=pair.part, seed=derive_seed(stream, "framing")
    )
    radiance = renderer(thing, framing, size=size)
    return exposed(radiance, scene, seed=derive_seed(stream, "camera"))


def tactile(thing: Surface, press: Press, domain: str, stream: int, *, size: int) -> Array:
    """Return TAC: the contact, as the domain's sensor feels it."""
    noise = derive_seed(stream, "sensor")
    if domain in _TAXIM:
        return calibrated(thing, press, _TAXIM[domain], size=size)
    sensor = DOMAINS[domain].sensor
    if sensor == "Tac3D":
        return felt(thing, press, size=size, seed=noise)
    return touch(thing, press, SENSORS[sensor], size=size, seed=noise)


def pressing(rng: np.random.Generator, thing: Surface) -> Press:
    """Draw place, pose, depth and drag of a press; people line a sensor up with what they touch."""
    at, lean, shear = rng.uniform(-12, 12, 2), rng.normal(0, 0.012, 2), rng.normal(0, 0.08, 2)
    return Press(
        at=(float(at[0]), float(at[1])),
        turn=thing.axis + float(rng.normal(0, 0.35)),
        lean=(float(lean[0]), float(lean[1])),
        depth=float(rng.uniform(0, 1)),
        shear=(float(shear[0]), float(shear[1])),
    )
