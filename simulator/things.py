"""A thing: one object's solid, appearance, touch surface and touched spot."""

from dataclasses import dataclass, replace

import numpy as np

from omnivat.kit.seeding import derive_seed
from simulator.noise import Rng, plane
from simulator.plan import EMBOSSED, OTHER_SHAPE, Planned
from simulator.shapes import KINDS, OBJECTS, PARTS, Solid, Spot, kind_of, made_of, spot
from simulator.shapes.spots import contact_height
from simulator.surfaces import SMOOTH, Surface, recipe, skinned, spend, surface

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
        maker = SMOOTH[pair.feels_like]
        own = maker(rng)
        spend(pair.feels_like, rng)
    else:
        maker = recipe(pair.material, pair.number, seed=seed)
        own = surface(pair.material, pair.number, seed=seed)
    return skinned(own, pair.feels_like or pair.material, maker, rng)


def touched_spot(solid: Solid, rng: Rng, *, edges: bool) -> Spot:
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
    near = np.hypot(*plane(_FIELD, _PIXELS)) <= _NEAR
    return float(height.max() - height[near].max())


_IMITATOR = 5_000  # added to the number, so that an imitation does not copy an object of its domain


@dataclass(frozen=True, slots=True, kw_only=True)
class Thing:
    """One object. `sight` and `touch` are one surface unless it imitates another class by sight."""

    solid: Solid
    sight: Surface  # colour, gloss and bumps for the photograph, on the solid's uv in mm
    touch: Surface  # relief under the sensor, on the same uv
    spot: Spot


def thing(pair: Planned, *, seed: int) -> Thing:
    """Return the object of a planned pair; the same seed and pair give the same object."""
    rng = np.random.default_rng(derive_seed(seed, "thing", pair.domain, pair.material, pair.number))
    seen = surface(
        pair.looks_like or pair.material, pair.number + _IMITATOR * bool(pair.looks_like), seed=seed
    )
    if pair.looks_like:  # a print or a coat: the same picture, with less relief
        seen = replace(seen, relief=EMBOSSED * seen.relief)
    # Most imitations have a shape of the class that they look like.
    shaped = pair.looks_like if pair.looks_like and rng.random() < OTHER_SHAPE else pair.material
    kind = kind_of((PARTS if rng.random() < pair.made.scene.parts else OBJECTS)[shaped], rng)
    solid = KINDS[kind](rng, made_of(pair.material, rng))
    place = touched_spot(solid, rng, edges=kind != "floor")
    return Thing(solid=solid, sight=seen, touch=touch_surface(pair, seed=seed), spot=place)


def is_outdoors(pair: Planned, rng: Rng) -> bool:
    """True if the photograph is taken outdoors, for domains with both."""
    if pair.made.series:
        return pair.part == "outdoor"
    return bool(rng.random() < pair.made.scene.outdoors)
