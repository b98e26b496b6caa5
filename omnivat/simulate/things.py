"""A thing: one object's solid, appearance, touch surface and touched spot."""

from dataclasses import dataclass, replace

import numpy as np

from omnivat.data.domains import DOMAINS
from omnivat.seeding import derive_seed
from omnivat.simulate.looks import EMBOSSED, OTHER_SHAPE
from omnivat.simulate.noise import Array
from omnivat.simulate.plan import Planned
from omnivat.simulate.scenes import SCENES
from omnivat.simulate.shapes import KINDS, OBJECTS, PARTS, Solid, Spot, kind_of, made_of
from omnivat.simulate.surfaces import Surface, surface
from omnivat.simulate.touches import touch_surface, touched_spot

_IMITATOR = 5_000  # added to the number, so that an imitation does not copy an object of its domain

_WIDE = ("floor",)  # their edges are never pressed


@dataclass(frozen=True, slots=True, kw_only=True)
class Thing:
    """One object. `sight` and `touch` are one surface unless it imitates another class by sight."""

    solid: Solid
    sight: Surface  # colour, gloss and bumps for the photograph, on the solid's uv in mm
    touch: Surface  # relief under the sensor, on the same uv
    spot: Spot
    material: str
    looks_like: str = ""
    feels_like: str = ""


def thing(pair: Planned, *, seed: int) -> Thing:
    """Return the object of a planned pair; the same seed and pair give the same object."""
    rng = np.random.default_rng(derive_seed(seed, "thing", pair.domain, pair.material, pair.number))
    own = surface(pair.material, pair.number, seed=seed)
    seen = own
    if pair.looks_like:
        seen = printed(surface(pair.looks_like, pair.number + _IMITATOR, seed=seed))
    solid = _shape(pair, rng)
    return Thing(
        solid=solid,
        sight=seen,
        touch=touch_surface(pair, seed=seed),
        spot=touched_spot(solid, rng, edges=solid.name not in _WIDE),
        material=pair.material,
        looks_like=pair.looks_like,
        feels_like=pair.feels_like,
    )


def printed(original: Surface) -> Surface:
    """Return a surface as a print or a coat: the same picture, with less relief."""

    def relief(x: Array, y: Array) -> Array:
        return EMBOSSED * original.relief(x, y)

    return replace(original, relief=relief)


def _shape(pair: Planned, rng: np.random.Generator) -> Solid:
    """Return the solid: mostly of the class that the object looks like."""
    imitates = bool(pair.looks_like) and rng.random() < OTHER_SHAPE
    material = pair.looks_like if imitates else pair.material
    outside = rng.random() < SCENES[pair.domain].parts
    weights = (PARTS if outside else OBJECTS)[material]
    return KINDS[kind_of(weights, rng)](rng, made_of(pair.material, rng))


def is_outdoors(pair: Planned, rng: np.random.Generator) -> bool:
    """True if the photograph is taken outdoors, for domains with both."""
    if DOMAINS[pair.domain].series:
        return pair.part == "outdoor"
    return bool(rng.random() < SCENES[pair.domain].outdoors)
