"""Wall thickness and edge radius of each material."""

from dataclasses import dataclass

import numpy as np

_WALL = {  # mm
    "wood": (6.0, 11.0), "steel": (0.7, 1.5), "plastic": (1.4, 3.0), "ceramic": (3.5, 6.5),
    "glass": (1.8, 3.8),
}  # fmt: skip
_BEVEL = {  # mm
    "wood": (2.0, 5.0), "steel": (0.3, 0.8), "plastic": (0.6, 1.5), "ceramic": (1.5, 3.0),
    "glass": (1.0, 2.0),
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """The thickness of an object's walls and the radius of its edges, mm."""

    wall: float
    bevel: float


def made_of(material: str, rng: np.random.Generator) -> Made:
    """Draw how an object of this material is made."""
    return Made(
        wall=float(rng.uniform(*_WALL[material])), bevel=float(rng.uniform(*_BEVEL[material]))
    )
