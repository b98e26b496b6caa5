"""Pictures that a fill of printed dots must leave as they are: dark grain, letters, holes, relief.

Each function draws one kind, values (side, side, 3) from 0 to 255; equal seeds give equal pictures.
Lengths are drawn for 224 pixels and grow with the side.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from scipy.ndimage import gaussian_filter, zoom

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
    missing: float = 0.0,
    bulge: float = 0.0,
    darkness: float = 0.8,
    seed: int = 0,
) -> Array:
    """Return the share of light (side, side) that printed dots take; lengths in pixels of
    `side`.
    """
    random = np.random.default_rng(seed)
    y, x = np.mgrid[:side, :side] - side / 2
    pushed = 1 - bulge * np.exp(-(x**2 + y**2) / (2 * (side / 5) ** 2))
    u = pushed * (x * np.cos(turn) + y * np.sin(turn)) + pitch / 3
    v = pushed * (y * np.cos(turn) - x * np.sin(turn)) + pitch / 4
    i, j = np.round(u / pitch).astype(int), np.round(v / pitch).astype(int)
    du, dv = u - i * pitch, v - j * pitch
    away = np.maximum(np.abs(du), np.abs(dv)) if square else np.hypot(du, dv)
    there = random.random((99, 99)) >= missing
    return np.asarray(darkness * np.clip(radius + 0.5 - away, 0, 1) * there[i + 49, j + 49])


def flat(side: int, seed: int) -> Array:
    return np.full((side, side, 3), 128.0 + seed)


def snow(side: int, seed: int) -> Array:
    return np.random.default_rng(seed).uniform(0, 255, (side, side, 3))


def plain(side: int, seed: int) -> Array:
    return gel(side, seed)


def specks(side: int, seed: int) -> Array:
    """Dark grain of many sizes, without a grid."""
    random, shade = np.random.default_rng(seed), np.zeros((side, side))
    y, x = places(side)
    for u, v, r in zip(*random.uniform(0, SIDE, (2, 90)), random.uniform(2, 6, 90), strict=True):
        shade = np.maximum(shade, 0.8 * np.clip(r - np.hypot(x - u, y - v), 0, 1))
    return gel(side, seed) * (1 - shade[..., None])


def grey_frame(side: int, seed: int) -> Array:
    noise = gaussian_filter(np.random.default_rng(seed).normal(size=(side, side)), 2.5)
    return np.repeat((150 + 300 * noise)[..., None], 3, 2)


def letters(side: int, seed: int) -> Array:
    page, size = Image.new("L", (side, side), 190), 11 * side // SIDE
    text = "the quick brown fox jumps over the dog"
    words, font = text[seed % 30 :] + " " + text, ImageFont.load_default(size)
    for line in range(14):
        place = 6 * side // SIDE, 16 * line * side // SIDE
        ImageDraw.Draw(page).text(place, words, fill=40, font=font)
    return np.repeat(np.asarray(page, float)[..., None], 3, 2)


def stripes(side: int, seed: int) -> Array:
    y, x = places(side)
    return np.asarray(gel(side, seed) * (1 - 0.5 * (np.sin((x + 0.2 * y) / 3) > 0.6))[..., None])


def weave(side: int, seed: int) -> Array:
    y, x = places(side)
    return gel(side, seed) * (0.75 + 0.25 * np.sin(x / 2.2) * np.sin(y / 2.2))[..., None]


def knurl(side: int, seed: int) -> Array:
    """Lit relief in a grid: each side has its own colour."""
    y, x = places(side)
    slopes = [
        np.cos(x / 3.5) * np.sin(y / 3.5),
        np.sin(x / 3.5) * np.cos(y / 3.5),
        -np.cos(x / 3.5) * np.sin(y / 3.5),
    ]
    return np.asarray(gel(side, seed) + 70 * np.stack(slopes, -1))


def shell(side: int, seed: int) -> Array:
    y, x = places(side)
    rings = np.sin(np.hypot(x - 60 - seed, y - 240 + seed) / 3)
    return np.repeat((140 + 50 * rings)[..., None], 3, 2)


def row_of_holes(side: int, seed: int) -> Array:
    shade, scale = printed(side, 26 * side / SIDE, 4.5 * side / SIDE, seed=seed), side / SIDE
    shade[: round(90 * scale)] = shade[round(130 * scale) :] = 0
    return np.asarray(gel(side, seed) * (1 - shade[..., None]))


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
    for one in (
        plain, specks, grey_frame, letters, stripes, weave, knurl, shell, row_of_holes, corner,
        checkers, flat, snow,
    )
}  # fmt: skip


def picture(values: Array) -> Array:
    """Return values as a picture, uint8."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
