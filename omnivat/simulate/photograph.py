"""VIS: frame, render and photograph a thing with its domain's camera."""

from collections.abc import Callable

import numpy as np

from omnivat.seeding import derive_seed
from omnivat.simulate.camera import exposed
from omnivat.simulate.framing import framed
from omnivat.simulate.noise import Array
from omnivat.simulate.plan import Planned
from omnivat.simulate.scenes import SCENES
from omnivat.simulate.things import Thing, is_outdoors

Renderer = Callable[..., Array]


def photograph(thing: Thing, pair: Planned, stream: int, *, size: int, renderer: Renderer) -> Array:
    """Return VIS (size, size, 3), 0 to 1: the thing, with its touched place in view.

    stream  the pair's seed, from which framing and camera draw theirs
    """
    scene = SCENES[pair.domain]
    place = np.random.default_rng(derive_seed(stream, "place"))
    framing = framed(
        scene, thing, outdoors=is_outdoors(pair, place), seed=derive_seed(stream, "framing")
    )
    radiance = renderer(thing, framing, size=size)
    return exposed(radiance, scene, seed=derive_seed(stream, "camera"))
