"""Ground and background of an object: colours of a plane, (..., 3) linear."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from simulator.fields import Field, field, grain, mixed, orange_peel, smooth, streaks, tiles, tinted
from simulator.noise import Array, cells, smoothstep


def ground(name: str, x: Array, y: Array, *, seed: int) -> Array:
    """Return the colour of a ground at (x, y) mm, or of a background, y upwards."""
    return GROUNDS[name](seed)(x, y)


def _drawn(seed: int, low: float, high: float) -> Array:
    tone = np.random.default_rng(seed).uniform(low, high)
    return np.random.default_rng(seed + 1).uniform(-0.12, 0.12, 3) * tone + tone


def _grass(seed: int) -> Field:
    blades = sum(
        streaks(seed + turn, angle=0.9 * turn + 0.3, width=5.0, length=45.0) for turn in range(3)
    )
    return tinted((0.12, 0.15, 0.06), 0.22 * blades)


def _paving(seed: int) -> Field:
    stone = tinted(_drawn(seed, 0.2, 0.4), 0.12 * grain(seed, coarsest=20, finest=2.0))
    return mixed(0.35 * stone, stone, tiles(pitch=200.0, joint=7.0, angle=(seed % 97) / 30))


@field
def _pebbles(x: Array, y: Array, seed: int) -> Array:
    near, border = cells(x, y, seed, size=14.0)
    tone = 0.25 * orange_peel(seed, size=22.0)(x, y) - 0.04 * near
    return np.where(border < 1.5, -0.55, tone)


def _cloth(seed: int) -> Field:
    red, _, blue = _drawn(seed, 0.03, 0.12)
    weave = Field(lambda x, y: 0.1 * np.sin(x * 1.3) * np.sin(y * 1.3))
    return tinted((red, 0.9 * red, 2.2 * blue), weave + 0.15 * orange_peel(seed, size=90.0))


def _carpet(seed: int) -> Field:
    tufts = grain(seed, coarsest=9.0, finest=2.0)
    return tinted(_drawn(seed, 0.08, 0.35), 0.3 * tufts + 0.3 * orange_peel(seed, size=60))


@field
def _planks(x: Array, y: Array, seed: int, *, wide: float) -> Array:
    row = np.floor(y / wide)
    lines = streaks(seed, angle=0.0, width=3.0, length=220.0)(x + 977.0 * row, y)
    joint = smoothstep(np.abs(y / wide - row - 0.5), 0.485, 0.5)
    return 0.13 * lines + 0.12 * np.sin(row * 12.9898) - 0.6 * joint


def _stone(seed: int) -> Field:
    stone = tinted(_drawn(seed, 0.3, 0.6), 0.12 * grain(seed, coarsest=60.0, finest=4.0))
    return mixed(0.5 * stone, stone, tiles(pitch=300.0, joint=4.0, angle=(seed % 89) / 30))


@field
def _holes(x: Array, y: Array) -> Array:
    u, v = np.round(x / 25.0) * 25.0, np.round(y / 25.0) * 25.0
    return -0.85 * (1.0 - smoothstep(np.hypot(x - u, y - v), 3.0, 4.0))


def _foliage(seed: int) -> Field:
    leaves = grain(seed, coarsest=70.0, finest=9.0)
    gaps = smooth(orange_peel(seed + 9, size=160.0), 0.8, 1.3)
    sky = smooth(Field(lambda x, z: z) + 150.0 * orange_peel(seed + 5, size=300.0), 700.0, 900.0)
    return mixed(
        tinted((0.09, 0.13, 0.045), 0.55 * leaves - 0.7 * gaps), np.array([0.7, 0.8, 0.95]), sky
    )


@field
def _windows(x: Array, z: Array) -> NDArray[np.bool]:
    return (np.abs((x / 420.0) % 1.0 - 0.5) < 0.22) & (np.abs((z / 600.0) % 1.0 - 0.55) < 0.3)


@field
def _bricks(x: Array, z: Array) -> NDArray[np.bool]:
    row = np.floor(z / 75.0)
    return (np.abs((x / 215.0 + 0.5 * row) % 1.0 - 0.5) < 0.475) & (
        np.abs(z / 75 - row - 0.5) < 0.43
    )


def _street(seed: int) -> Field:
    tone = 0.2 * orange_peel(seed, size=120.0)
    wall = mixed(tinted((0.45, 0.42, 0.38), tone), tinted((0.33, 0.16, 0.1), tone), _bricks())
    return mixed(wall, np.array([0.12, 0.15, 0.19]), _windows())


@field
def _shelf(x: Array, z: Array, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    row, book = np.floor(z / 280.0), np.floor(x / 38.0)
    pick = ((book * 7 + row * 31).astype(int)) % 64
    colours = rng.uniform(0.03, 0.4, (64, 1)) * rng.uniform(0.5, 1.5, (64, 3))
    tops = rng.uniform(0.6, 0.9, 64)
    shown = np.where(((z / 280.0 - row) < tops[pick])[..., None], colours[pick], 0.03)
    return np.where(((z / 280.0 - row) > 0.94)[..., None], np.array([0.35, 0.2, 0.1]), shown)


def _wall(seed: int) -> Field:
    paint = tinted(_drawn(seed, 0.35, 0.75), 0.03 * orange_peel(seed, size=200.0))
    return mixed(paint, np.array([0.6, 0.58, 0.55]), Field(lambda x, z: z < 80.0))


def _door(seed: int) -> Field:
    middle = np.random.default_rng(seed).uniform(-300, 300)
    leaf = tinted((0.4, 0.26, 0.15), 0.1 * streaks(seed, angle=np.pi / 2, width=9, length=300))
    return mixed(_wall(seed), leaf, Field(lambda x, z: np.abs(x - middle) < 380.0))


def _even(value: float) -> Field:
    return Field(lambda x, y: np.full((*np.shape(x), 3), value))


GROUNDS: dict[str, Callable[[int], Field]] = {
    "grass": _grass, "paving": _paving, "cloth": _cloth, "carpet": _carpet, "stone": _stone,
    "gravel": lambda seed: tinted(_drawn(seed, 0.22, 0.38), _pebbles(seed)),
    "soil": lambda seed: tinted((0.21, 0.15, 0.10), 0.2 * grain(seed, coarsest=40.0, finest=2.5)),
    "parquet": lambda seed: tinted((0.38, 0.22, 0.11), _planks(seed, wide=70.0)),
    "oak": lambda seed: tinted((0.52, 0.36, 0.21), _planks(seed, wide=2000.0)),
    "laminate": lambda seed: tinted(_drawn(seed, 0.55, 0.75), 0.02 * orange_peel(seed, size=60.0)),
    "bench": lambda seed: tinted((0.08, 0.08, 0.09), _holes() + 0.04 * orange_peel(seed, size=40)),
    "turntable": lambda seed: tinted((0.74, 0.75, 0.77), 0.05 * orange_peel(seed, size=130.0)),
    "white": lambda seed: _even(0.9),
    "black": lambda seed: _even(0.012),
    # backgrounds
    "foliage": _foliage, "street": _street, "shelf": _shelf, "wall": _wall, "door": _door,
}  # fmt: skip
