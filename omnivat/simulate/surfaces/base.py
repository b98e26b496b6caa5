"""A surface: relief, colour and reflection as functions of position."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from omnivat.simulate.noise import Array

Field = Callable[[Array, Array], Array]  # (x, y) in mm -> (...) heights in mm, or (..., 3) colours
Gloss = Literal["matte", "coated", "metal", "glass"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Form:
    """The large shape: curvature along and across `angle`, 1/mm; 0 is flat, positive bulges."""

    along: float = 0.0
    across: float = 0.0
    angle: float = 0.0

    def height(self, x: Array, y: Array) -> Array:
        """Return the height of the form in mm at (x, y) mm, 0 at its middle."""
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        u, v = x * cos + y * sin, y * cos - x * sin
        return _arc(u, self.along) + _arc(v, self.across)


def _arc(u: Array, curvature: float) -> Array:
    """Return the sagitta of a circle, flattened before its sides turn vertical."""
    if curvature == 0.0:
        return np.zeros_like(u)
    reach = np.clip(np.abs(u * curvature), 0.0, 0.92)
    steep = np.abs(u * curvature) - reach
    return np.asarray(-((1.0 - np.sqrt(1.0 - reach**2)) + 2.3 * steep) / curvature)


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """One object's surface. The same one is photographed and pressed."""

    recipe: str  # such as "brushed"
    relief: Field  # mm
    colour: Field  # linear reflectance (or transmittance of glass), 0 to 1
    gloss: Gloss
    roughness: float  # microfacet width alpha of the shiny layer, 0.01 mirror to 0.6 dull
    brushing: float = 0.0  # 0 to 1: how much wider highlights are across `angle`
    angle: float = 0.0  # rad, direction of grain or brushing
    form: Form = Form()

    @property
    def axis(self) -> float:
        """Return the direction of the object's cylinder or grain, rad."""
        return self.form.angle if self.form.across else self.angle

    def height(self, x: Array, y: Array) -> Array:
        """Return form and relief together, mm."""
        return self.form.height(x, y) + self.relief(x, y)


def pick(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw evenly between two bounds."""
    return float(rng.uniform(low, high))


def pick_log(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw evenly in ratio between two positive bounds."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def stream(rng: np.random.Generator) -> int:
    """Draw a seed for one field."""
    return int(rng.integers(2**31))


def tinted(colour: tuple[float, float, float], amount: Array) -> Array:
    """Return `colour` times (1 + amount), (..., 3), kept within 0.01 to 0.98."""
    return np.clip(np.asarray(colour) * (1.0 + amount[..., None]), 0.01, 0.98)


def mixed(one: Array, other: Array, weight: Array) -> Array:
    """Return `one` where weight is 0 and `other` where it is 1; colours (..., 3)."""
    return one + (other - one) * weight[..., None]
