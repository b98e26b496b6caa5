"""A surface: relief, colour and reflection as functions of place."""

from dataclasses import KW_ONLY, dataclass
from typing import Literal

import numpy as np

from simulator.fields import Field
from simulator.noise import Rng


@dataclass(frozen=True, slots=True)
class Surface:
    """One object's surface. The same one is photographed and pressed."""

    relief: Field  # mm
    colour: Field  # linear reflectance (or transmittance of glass), 0 to 1
    _: KW_ONLY
    gloss: Literal["matte", "coated", "metal", "glass"]
    roughness: float  # microfacet width alpha of the shiny layer, 0.01 mirror to 0.6 dull
    brushing: float = 0.0  # 0 to 1: how much wider highlights are across `angle`
    angle: float = 0.0  # rad, direction of grain or brushing


def pick_log(rng: Rng, low: float, high: float) -> float:
    """Draw evenly in ratio between two positive bounds."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def stream(rng: Rng) -> int:
    """Draw a seed for one field."""
    return int(rng.integers(2**31))
