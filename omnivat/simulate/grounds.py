"""What lies behind an object in a photograph: colours of a plane, (..., 3) linear."""

from collections.abc import Callable

import numpy as np

from omnivat.simulate.noise import Array, smoothstep
from omnivat.simulate.surfaces.base import mixed, tinted
from omnivat.simulate.surfaces.patterns import grain, orange_peel, streaks, tiles


def ground(name: str, x: Array, y: Array, *, seed: int) -> Array:
    """Return the colour of the ground called `name` at (x, y) mm."""
    return np.asarray(_GROUNDS[name](x, y, seed))


def _grass(x: Array, y: Array, seed: int) -> Array:
    blades = sum(
        streaks(x, y, angle=0.9 * turn + 0.3, width=1.6, length=14.0, seed=seed + turn)
        for turn in range(3)
    )
    return tinted((0.12, 0.15, 0.06), 0.30 * np.asarray(blades))


def _paving(x: Array, y: Array, seed: int) -> Array:
    stone = tinted((0.34, 0.32, 0.30), 0.12 * grain(x, y, coarsest=6.0, finest=0.6, seed=seed))
    face = tiles(x, y, pitch=70.0, joint=4.0, angle=(seed % 97) / 30)
    return mixed(0.35 * stone, stone, face)


def _bark(x: Array, y: Array, seed: int) -> Array:
    rough = grain(x, y, coarsest=12.0, finest=0.8, seed=seed)
    return tinted((0.21, 0.14, 0.09), 0.35 * rough)


def _cloth(x: Array, y: Array, seed: int) -> Array:
    tone = np.random.default_rng(seed).uniform(0.05, 0.25, 3)
    weave = np.sin(x * 4.0) * np.sin(y * 4.0)
    folds = orange_peel(x, y, size=45.0, seed=seed)
    return tinted((tone[0], tone[1], tone[2]), 0.12 * weave + 0.15 * folds)


def _desk(x: Array, y: Array, seed: int) -> Array:
    tones = ((0.55, 0.42, 0.28), (0.62, 0.62, 0.60), (0.30, 0.30, 0.31), (0.70, 0.66, 0.58))
    lines = streaks(x, y, angle=0.2, width=3.0, length=90.0, seed=seed)
    return tinted(tones[seed % 4], 0.05 * lines * (seed % 4 in (0, 3)))


def _bench(x: Array, y: Array, seed: int) -> Array:
    u, v = np.round(x / 25.0) * 25.0, np.round(y / 25.0) * 25.0
    holes = 1.0 - smoothstep(np.hypot(x - u, y - v), 3.0, 3.6)
    return tinted((0.10, 0.10, 0.11), -0.85 * holes + 0.04 * orange_peel(x, y, size=9.0, seed=seed))


_GROUNDS: dict[str, Callable[[Array, Array, int], Array]] = {
    "grass": _grass,
    "paving": _paving,
    "bark": _bark,
    "cloth": _cloth,
    "desk": _desk,
    "bench": _bench,
    "white": lambda x, y, seed: np.full((*np.shape(x), 3), 0.9),
    "black": lambda x, y, seed: np.full((*np.shape(x), 3), 0.01),
}
