"""Fields: functions of place that add and multiply like numbers, and the patterns that materials
share.
"""

import operator
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, Concatenate, ParamSpec

import numpy as np
from numpy.typing import NDArray

from simulator.noise import Array, cells, noise, octaves, smoothstep, turned

P = ParamSpec("P")


def lifted(function: Callable[..., Array]) -> "Callable[..., Field]":
    """Make a function of arrays one of fields and numbers, which returns a field."""

    @wraps(function)
    def of_fields(*arguments: Any) -> "Field":
        return Field(
            lambda x, y: function(
                *(
                    argument(x, y) if isinstance(argument, Field) else argument
                    for argument in arguments
                )
            )
        )

    return of_fields


class Field:
    """A function of place: (x, y) in mm -> (...) heights in mm, or (..., 3) colours."""

    __array_ufunc__ = None  # an array on the left leaves the sum to the field
    __add__ = __radd__ = lifted(operator.add)
    __mul__ = __rmul__ = lifted(operator.mul)
    __sub__, __rsub__ = lifted(operator.sub), lifted(lambda first, other: other - first)

    def __init__(self, at: Callable[[Array, Array], NDArray[Any]]) -> None:
        self._at = at

    def __call__(self, x: Array, y: Array) -> Array:
        return self._at(x, y)

    def moved(self, by: "Field") -> "Field":
        """Return the field at places that lie `by` mm further along both axes."""
        return Field(lambda x, y: self(x + (away := by(x, y)), y + away))


def field(pattern: Callable[Concatenate[Array, Array, P], NDArray[Any]]) -> Callable[P, Field]:
    """Make a function of (x, y) and settings one of the settings, which returns a field."""

    @wraps(pattern)
    def made(*arguments: P.args, **named: P.kwargs) -> Field:
        return Field(lambda x, y: pattern(x, y, *arguments, **named))

    return made


smooth = lifted(smoothstep)


@lifted
def tinted(colour: Sequence[float] | Array, amount: Array) -> Array:
    """Return `colour` times (1 + amount), (..., 3), kept within 0.01 to 0.98."""
    return np.clip(colour * (1.0 + amount[..., None]), 0.01, 0.98)


@lifted
def mixed(first: Array, other: Array, weight: Array) -> Array:
    """Return `first` where weight is 0 and `other` where it is 1; colours (..., 3)."""
    return first + (other - first) * weight[..., None]


@field
def streaks(x: Array, y: Array, seed: int, *, angle: float, width: float, length: float) -> Array:
    """Return unit-spread noise drawn out along `angle`: brushing, wood grain, extrusion lines."""
    u, v = turned(x, y, angle)
    stretch = width / length
    total = np.zeros(np.broadcast(x, y).shape)
    for step, (scale, weight) in enumerate(((1.0, 1.0), (0.5, 0.7), (0.25, 0.5))):
        # the noise's turn is undone
        own = 2 * np.pi * np.random.default_rng(seed + step).uniform(0.0, 1.0, 3)[2]
        total += weight * noise(
            *turned(u * stretch, v, -own), seed + step, wavelength=width * scale
        )
    return total / 1.32


@field
def ribs(x: Array, y: Array, *, angle: float, pitch: float, sharpness: float = 1.0) -> Array:
    """Return parallel ribs from 0 to 1, `pitch` mm apart; sharpness above 1 narrows them."""
    _, v = turned(x, y, angle)
    return (0.5 + 0.5 * np.cos(2 * np.pi * v / pitch)) ** sharpness


@field
def arcs(x: Array, y: Array, *, centre: tuple[float, float], pitch: float) -> Array:
    """Return round grooves about `centre`, from -1 to 1: turning, milling, throwing, rings."""
    radius = np.hypot(x - centre[0], y - centre[1])
    return np.sin(2 * np.pi * radius / pitch)


@field
def dots(x: Array, y: Array, *, pitch: float, radius: float, angle: float, edge: float) -> Array:
    """Return round pads from 0 to 1 on a square lattice; `edge` mm is how soft their rim is."""
    u, v = turned(x, y, angle)
    du, dv = (u / pitch - np.round(u / pitch)) * pitch, (v / pitch - np.round(v / pitch)) * pitch
    return 1.0 - smoothstep(np.hypot(du, dv), radius - edge, radius + edge)


@field
def diamonds(x: Array, y: Array, *, pitch: float, angle: float) -> Array:
    """Return pyramids from 0 to 1 between two crossing families of V grooves: knurl, cut glass."""
    sides = (turned(x, y, angle + lean)[1] / pitch for lean in (0.0, np.pi / 3))
    return np.minimum(*(2.0 * np.abs(side - np.round(side)) for side in sides))


@field
def treads(x: Array, y: Array, *, pitch: float, angle: float) -> Array:
    """Return the lens-shaped bars of chequer plate, 0 to 1, turned by turns."""
    u, v = turned(x, y, angle)
    column, row = np.round(u / pitch), np.round(v / pitch)
    du, dv = u - column * pitch, v - row * pitch
    flip = np.where((column + row) % 2 == 0, 1.0, -1.0)
    long, short = (du + flip * dv) / np.sqrt(2), (dv - flip * du) / np.sqrt(2)
    lens = 1.0 - (long / (0.55 * pitch)) ** 2 - (short / (0.16 * pitch)) ** 2
    return smoothstep(lens, 0.0, 0.8)


@field
def tiles(x: Array, y: Array, *, pitch: float, joint: float, angle: float) -> Array:
    """Return 1 on square tiles and 0 in joints `joint` mm wide, with rounded rims."""
    u, v = turned(x, y, angle)
    across, along = (np.abs(w - (np.floor(w / pitch) + 0.5) * pitch) for w in (u, v))
    return smoothstep(pitch / 2 - np.maximum(across, along), joint / 2, joint / 2 + 0.6)


@field
def cracks(x: Array, y: Array, seed: int, *, size: float, width: float) -> Array:
    """Return 1 on a net of fine cracks and 0 between them: crazed glaze, old paint."""
    wander = 0.18 * size
    bent_x = x + wander * noise(x, y, seed + 1, wavelength=size * 0.7)
    bent_y = y + wander * noise(x, y, seed + 2, wavelength=size * 0.7)
    _, border = cells(bent_x, bent_y, seed, size=size)
    return 1.0 - smoothstep(border, 0.2 * width, width)


@field
def borders(x: Array, y: Array, seed: int, *, size: float) -> Array:
    """Return the distance (mm) to the nearest border between cells of `size` mm."""
    return cells(x, y, seed, size=size)[1]


@field
def scratches(x: Array, y: Array, seed: int, *, count: int, reach: float, width: float) -> Array:
    """Return 1 in `count` straight scratches within `reach` mm of the middle, 0 elsewhere."""
    rng = np.random.default_rng(seed)
    deepest = np.zeros(np.broadcast(x, y).shape)
    for _ in range(count):
        px, py = rng.uniform(-reach, reach, 2)
        u, v = turned(x - px, y - py, rng.uniform(0, np.pi))
        length = rng.uniform(0.1, 0.5) * reach
        inside = np.exp(-((v / width) ** 2)) * smoothstep(length - np.abs(u), 0.0, 0.3 * length)
        deepest = np.maximum(deepest, rng.uniform(0.3, 1.0) * inside)
    return deepest


@field
def pits(x: Array, y: Array, seed: int, *, size: float, radius: float, share: float) -> Array:
    """Return 1 in scattered round pits (or specks) and 0 elsewhere; `share` of cells have one."""
    near, _ = cells(x, y, seed, size=size, jitter=0.8)
    off = (1.0 - share) - 0.5
    least = 2.6 * off + 1.2 * off**3  # near the normal quantile
    chosen = noise(x, y, seed + 1, wavelength=size * 1.5) > least
    return (1.0 - smoothstep(near, 0.5 * radius, radius)) * chosen


@field
def grain(x: Array, y: Array, seed: int, *, coarsest: float, finest: float) -> Array:
    """Return unit-spread roughness without direction: blasting, casting, spark erosion, clay."""
    return octaves(x, y, seed, wavelength=coarsest, finest=finest, roughness=0.75)


@field
def orange_peel(x: Array, y: Array, seed: int, *, size: float) -> Array:
    """Return the soft waviness of paint, glaze and moulded gloss, unit spread."""
    return octaves(x, y, seed, wavelength=size, finest=size / 2, roughness=0.5)
