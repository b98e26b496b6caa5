"""Pictures that a fill of printed dots must leave as they are: specks, meshes, letters, relief.

Each function draws one kind, values (side, side, 3) from 0 to 255; equal seeds give equal pictures.
Lengths are drawn for 224 pixels and grow with the side.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.ndimage import zoom

SIDE = 224
Array = np.ndarray[Any, np.dtype[Any]]


def gel(side: int = SIDE, seed: int = 0, grain: float = 4.0) -> Array:
    """A lit gel: slow changes of colour, and grain."""
    random = np.random.default_rng(seed)
    slow = zoom(random.uniform(90, 200, (4, 4, 3)), (side / 4, side / 4, 1), order=1)
    return np.asarray(slow[:side, :side] + random.normal(0, grain, (side, side, 3)))


def places(side: int) -> tuple[Array, Array]:
    """Return rows and columns in pixels of 224."""
    y, x = np.mgrid[:side, :side] * (SIDE / side)
    return y, x


def printed(
    side: int = SIDE,
    pitch: float = 26.0,
    radius: float = 4.5,
    *,
    square: bool = False,
    turn: float = 0.0,
    darkness: float = 0.8,
) -> Array:
    """Return the share of light (side, side) that printed dots take; lengths in pixels of
    `side`.
    """
    y, x = np.mgrid[:side, :side] - side / 2
    u = x * np.cos(turn) + y * np.sin(turn) + pitch / 3
    v = y * np.cos(turn) - x * np.sin(turn) + pitch / 4
    du, dv = u - np.round(u / pitch) * pitch, v - np.round(v / pitch) * pitch
    away = np.maximum(np.abs(du), np.abs(dv)) if square else np.hypot(du, dv)
    return np.asarray(darkness * np.clip(radius + 0.5 - away, 0, 1))


def snow(side: int, seed: int) -> Array:
    return np.random.default_rng(seed).uniform(0, 255, (side, side, 3))


def dots_among_specks(side: int, seed: int) -> Array:
    random, shade = np.random.default_rng(seed), printed(side)
    y, x = places(side)
    for u, v in random.uniform(0, SIDE, (140, 2)):
        shade = np.maximum(shade, 0.8 * np.clip(5 - np.hypot(x - u, y - v), 0, 1))
    return gel(side, seed) * (1 - shade[..., None])


def soft_lines(side: int, seed: int) -> Array:
    """A mesh whose crossings are darkest."""
    shade = sum(0.4 * np.exp(8 * (np.cos(2 * np.pi * at / 26) - 1)) for at in places(side))
    return np.asarray(gel(side, seed) * (1 - shade)[..., None])


def corner(side: int, seed: int) -> Array:
    """Dots in one corner only."""
    shade, end = printed(side, 20 * side / SIDE, 3 * side / SIDE), 110 * side // SIDE
    shade[end:] = shade[:, end:] = 0
    return np.asarray(gel(side, seed) * (1 - shade[..., None]))


def checkers(side: int, seed: int) -> Array:
    y, x = places(side)
    light = np.where(((x + seed) // 14 + y // 14) % 2, 60.0, 190.0)
    return np.repeat(light[..., None], 3, 2)


ODD: dict[str, Callable[[int, int], Array]] = {
    one.__name__.replace("_", " "): one
    for one in (gel, snow, dots_among_specks, soft_lines, corner, checkers)
}


def picture(values: Array) -> Array:
    """Return values as a picture, uint8."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
