"""The pressed spot of an object, and its touch surface."""

import numpy as np

from omnivat.seeding import derive_seed
from omnivat.simulate.heights import contact_height
from omnivat.simulate.plan import Planned
from omnivat.simulate.shapes import Solid, Spot, spot
from omnivat.simulate.surfaces import Surface, recipe, surface
from omnivat.simulate.surfaces.skins import SMOOTH, skinned

_TRIES = 8
_FIELD = 14.0  # mm: smallest field of all sensors
_NEAR = 3.5  # mm from the middle of the sensor to the highest point of the object
_PIXELS = 36


def touch_surface(pair: Planned, *, seed: int) -> Surface:
    """Return the touch surface; the same seed and pair give the same surface.

    An object that feels like another class has a smooth surface of that class: gloss, glaze or
    polish. Every surface has the micro-relief of its own material, or of the one it feels like.
    """
    rng = np.random.default_rng(derive_seed(seed, "skin", pair.material, pair.number))
    if pair.feels_like:
        maker = SMOOTH[pair.feels_like][0]
        return skinned(maker(rng), pair.feels_like, maker, rng)
    maker = recipe(pair.material, pair.number, seed=seed)
    own = surface(pair.material, pair.number, seed=seed)
    return skinned(own, pair.material, maker, rng)


def touched_spot(solid: Solid, rng: np.random.Generator, *, edges: bool = True) -> Spot:
    """Return a spot where the sensor touches the object first at the middle of its gel.

    edges  True to press edges and rims, too

    Several spots are tried, because people also adjust a sensor. The first such spot is used, or
    the best one.
    """
    drawn, worst = [], []
    for _ in range(_TRIES):
        drawn.append(spot(solid, rng, edges=edges))
        worst.append(_beside(solid, drawn[-1]))
        if worst[-1] <= 0.1:
            return drawn[-1]
    return drawn[int(np.argmin(worst))]


def _beside(solid: Solid, place: Spot) -> float:
    """Return the height (mm) of the object beside the middle of the gel, over the middle."""
    height = contact_height(solid, place, field=_FIELD, size=_PIXELS)
    axis = (np.arange(_PIXELS) + 0.5) / _PIXELS * _FIELD - _FIELD / 2
    near = np.hypot(*np.meshgrid(axis, axis)) <= _NEAR
    return float(height.max() - height[near].max())
