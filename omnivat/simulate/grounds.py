"""Ground and background of an object: colours of a plane, (..., 3) linear."""

from collections.abc import Callable
from functools import partial

import numpy as np

from omnivat.simulate.noise import Array, cells, smoothstep
from omnivat.simulate.surfaces.base import grain, mixed, orange_peel, streaks, tiles, tinted


def ground(name: str, x: Array, y: Array, *, seed: int) -> Array:
    """Return the colour of the ground called `name` at (x, y) mm."""
    return np.asarray(_GROUNDS[name](x, y, seed))


def beyond(name: str, x: Array, z: Array, *, seed: int) -> Array:
    """Return the colour of the background called `name` at (x, z) mm, z upwards."""
    return np.asarray(_BEYOND[name](x, z, seed))


def _drawn(seed: int, low: float, high: float) -> tuple[float, float, float]:
    tone = np.random.default_rng(seed).uniform(low, high)
    tint = np.random.default_rng(seed + 1).uniform(-0.12, 0.12, 3) * tone + tone
    return (float(tint[0]), float(tint[1]), float(tint[2]))


def _grass(x: Array, y: Array, seed: int) -> Array:
    blades = sum(streaks(x, y, angle=0.9 * turn + 0.3, width=5.0, length=45.0, seed=seed + turn) for turn in range(3))
    return tinted((0.12, 0.15, 0.06), 0.22 * np.asarray(blades))


def _paving(x: Array, y: Array, seed: int) -> Array:
    stone = tinted(_drawn(seed, 0.2, 0.4), 0.12 * grain(x, y, coarsest=20, finest=2.0, seed=seed))
    face = tiles(x, y, pitch=200.0, joint=7.0, angle=(seed % 97) / 30)
    return mixed(0.35 * stone, stone, face)


def _gravel(x: Array, y: Array, seed: int) -> Array:
    near, border = cells(x, y, size=14.0, seed=seed)
    tone = 0.25 * orange_peel(x, y, size=22.0, seed=seed) - 0.04 * near
    return tinted(_drawn(seed, 0.22, 0.38), np.where(border < 1.5, -0.55, tone))


def _cloth(x: Array, y: Array, seed: int) -> Array:
    red, _, blue = _drawn(seed, 0.03, 0.12)
    folds = orange_peel(x, y, size=90.0, seed=seed)
    return tinted((red, 0.9 * red, 2.2 * blue), 0.1 * np.sin(x * 1.3) * np.sin(y * 1.3) + 0.15 * folds)


def _carpet(x: Array, y: Array, seed: int) -> Array:
    tufts = grain(x, y, coarsest=9.0, finest=2.0, seed=seed)
    return tinted(_drawn(seed, 0.08, 0.35), 0.3 * tufts + 0.3 * orange_peel(x, y, size=60, seed=seed))


def _planks(x: Array, y: Array, seed: int, *, wide: float, tone: tuple[float, float, float]) -> Array:
    row = np.floor(y / wide)
    lines = streaks(x + 977.0 * row, y, angle=0.0, width=3.0, length=220.0, seed=seed)
    joint = smoothstep(np.abs(y / wide - row - 0.5), 0.485, 0.5)
    return tinted(tone, 0.13 * lines + 0.12 * np.sin(row * 12.9898) - 0.6 * joint)


def _stone(x: Array, y: Array, seed: int) -> Array:
    veins = grain(x, y, coarsest=60.0, finest=4.0, seed=seed)
    face = tiles(x, y, pitch=300.0, joint=4.0, angle=(seed % 89) / 30)
    stone = tinted(_drawn(seed, 0.3, 0.6), 0.12 * veins)
    return mixed(0.5 * stone, stone, face)


def _bench(x: Array, y: Array, seed: int) -> Array:
    u, v = np.round(x / 25.0) * 25.0, np.round(y / 25.0) * 25.0
    holes = 1.0 - smoothstep(np.hypot(x - u, y - v), 3.0, 4.0)
    return tinted((0.08, 0.08, 0.09), -0.85 * holes + 0.04 * orange_peel(x, y, size=40, seed=seed))


def _white_cloth(x: Array, y: Array, seed: int) -> Array:
    return tinted((0.74, 0.75, 0.77), 0.05 * orange_peel(x, y, size=130.0, seed=seed))


def _foliage(x: Array, z: Array, seed: int) -> Array:
    leaves = grain(x, z, coarsest=70.0, finest=9.0, seed=seed)
    gaps = smoothstep(orange_peel(x, z, size=160.0, seed=seed + 9), 0.8, 1.3)
    sky = smoothstep(z + 150.0 * orange_peel(x, z, size=300.0, seed=seed + 5), 700.0, 900.0)
    green = tinted((0.09, 0.13, 0.045), 0.55 * leaves - 0.7 * gaps)
    return mixed(green, np.array([0.7, 0.8, 0.95]), sky)


def _street(x: Array, z: Array, seed: int) -> Array:
    wall = _bricks(x, z, seed)
    window = (np.abs((x / 420.0) % 1.0 - 0.5) < 0.22) & (np.abs((z / 600.0) % 1.0 - 0.55) < 0.3)
    return mixed(wall, np.array([0.12, 0.15, 0.19]), window.astype(np.float64))


def _bricks(x: Array, z: Array, seed: int) -> Array:
    row = np.floor(z / 75.0)
    inside = (np.abs((x / 215.0 + 0.5 * row) % 1.0 - 0.5) < 0.475) & (np.abs(z / 75 - row - 0.5) < 0.43)
    tone = 0.2 * orange_peel(x, z, size=120.0, seed=seed)
    return mixed(tinted((0.45, 0.42, 0.38), tone), tinted((0.33, 0.16, 0.1), tone), inside.astype(np.float64))


def _shelf(x: Array, z: Array, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    row, book = np.floor(z / 280.0), np.floor(x / 38.0)
    pick = ((book * 7 + row * 31).astype(int)) % 64
    colours = rng.uniform(0.03, 0.4, (64, 1)) * rng.uniform(0.5, 1.5, (64, 3))
    tops = rng.uniform(0.6, 0.9, 64)
    inside = (z / 280.0 - row) < tops[pick]
    frame = (z / 280.0 - row) > 0.94
    shown = np.where(inside[..., None], colours[pick], 0.03)
    return np.where(frame[..., None], np.array([0.35, 0.2, 0.1]), shown)


def _wall(x: Array, z: Array, seed: int) -> Array:
    paint = tinted(_drawn(seed, 0.35, 0.75), 0.03 * orange_peel(x, z, size=200.0, seed=seed))
    return mixed(paint, np.array([0.6, 0.58, 0.55]), (z < 80.0).astype(np.float64))


def _door(x: Array, z: Array, seed: int) -> Array:
    wall = _wall(x, z, seed)
    u = x - np.random.default_rng(seed).uniform(-300, 300)
    leaf = tinted((0.4, 0.26, 0.15), 0.1 * streaks(x, z, angle=np.pi / 2, width=9, length=300, seed=seed))
    return mixed(wall, leaf, (np.abs(u) < 380.0).astype(np.float64))


_Plane = Callable[[Array, Array, int], Array]
_GROUNDS: dict[str, _Plane] = {
    "grass": _grass, "paving": _paving, "gravel": _gravel, "cloth": _cloth, "carpet": _carpet, "stone": _stone,
    "soil": lambda x, y, seed: tinted(
        (0.21, 0.15, 0.10), 0.2 * grain(x, y, coarsest=40.0, finest=2.5, seed=seed)),
    "parquet": partial(_planks, wide=70.0, tone=(0.38, 0.22, 0.11)),
    "oak": partial(_planks, wide=2000.0, tone=(0.52, 0.36, 0.21)),
    "laminate": lambda x, y, seed: tinted(
        _drawn(seed, 0.55, 0.75), 0.02 * orange_peel(x, y, size=60.0, seed=seed)),
    "bench": _bench, "turntable": _white_cloth,
    "white": lambda x, y, seed: np.full((*np.shape(x), 3), 0.9),
    "black": lambda x, y, seed: np.full((*np.shape(x), 3), 0.012),
}  # fmt: skip
_BEYOND: dict[str, _Plane] = {
    "foliage": _foliage, "street": _street, "shelf": _shelf, "wall": _wall, "door": _door,
    "sheet": _white_cloth,
}  # fmt: skip
