"""Glass surfaces: float, rippled, reeded, pebbled, frosted, cut, pressed, bottle."""

import numpy as np

from simulator.fields import (
    Field,
    diamonds,
    dots,
    field,
    grain,
    orange_peel,
    ribs,
    scratches,
    tinted,
)
from simulator.noise import Array, Rng, cells, one_of
from simulator.surfaces.base import Surface, pick_log, stream

_TINTS = (
    (0.93, 0.96, 0.95), (0.95, 0.96, 0.96), (0.62, 0.86, 0.70), (0.80, 0.52, 0.20),
    (0.45, 0.66, 0.88), (0.88, 0.93, 0.91),
)  # fmt: skip


def _glass(rng: Rng, relief: Field, *, vessel: bool = False, dull: bool = False) -> Surface:
    """Return glass of one tint with this relief."""
    rng.random(2 + (rng.random() >= 0.6) if vessel else 1)  # once a curvature; keeps shipped bytes
    skin = rng.uniform(0.25, 0.4) if dull else 0.02
    tint, seed = one_of(_TINTS, rng), stream(rng)
    colour = tinted(tint, 0.01 * orange_peel(seed, size=30.0))
    return Surface(relief, colour, gloss="glass", roughness=skin)


def float_glass(rng: Rng) -> Surface:
    """Return a pane or a smooth vessel: nothing to feel but a scratch or two."""
    seed, count = stream(rng), int(rng.integers(0, 5))
    used = scratches(seed, count=count, reach=30.0, width=0.05)
    relief = 0.0012 * orange_peel(seed + 1, size=8.0) - 0.01 * used
    return _glass(rng, relief, vessel=rng.random() >= 0.7)


def rippled(rng: Rng) -> Surface:
    """Return old or rippled glass: smooth, long, gentle waves."""
    seed, size, rise = stream(rng), rng.uniform(4.0, 9.0), rng.uniform(0.06, 0.18)
    return _glass(rng, rise * orange_peel(seed, size=size))


def reeded(rng: Rng) -> Surface:
    """Return fluted glass: exact, smooth ribs, which plastic has too."""
    angle, pitch, rise = rng.uniform(0, np.pi), rng.uniform(3.0, 7.0), rng.uniform(0.25, 0.5)
    return _glass(
        rng, rise * ribs(angle=angle, pitch=pitch, sharpness=0.6), vessel=rng.random() >= 0.5
    )


def pebbled(rng: Rng) -> Surface:
    """Return hammered glass: round smooth cushions, close together."""
    seed, size, rise = stream(rng), rng.uniform(3.0, 6.0), rng.uniform(0.10, 0.28)

    @field
    def cushions(x: Array, y: Array) -> Array:
        near, _ = cells(x, y, seed, size=size, jitter=0.7)
        return -rise * (near / size) ** 2 * 2.0

    return _glass(rng, cushions())


def frosted(rng: Rng) -> Surface:
    """Return acid-etched or blasted glass: very fine tooth, milky look."""
    seed, depth = stream(rng), pick_log(rng, 0.003, 0.009)
    relief = depth * grain(seed, coarsest=0.5, finest=0.15)
    return _glass(rng, relief, vessel=rng.random() < 0.4, dull=True)


def cut(rng: Rng) -> Surface:
    """Return cut crystal: crossing V grooves, sharp and smooth."""
    angle, pitch, rise = rng.uniform(0, np.pi), rng.uniform(4.0, 8.0), rng.uniform(0.5, 0.9)
    return _glass(rng, rise * diamonds(pitch=pitch, angle=angle), vessel=rng.random() < 0.5)


def pressed(rng: Rng) -> Surface:
    """Return pressed glass: smooth hobnails in rows."""
    angle, pitch, rise = rng.uniform(0, np.pi), rng.uniform(4.5, 9.0), rng.uniform(0.3, 0.6)
    relief = rise * dots(pitch=pitch, radius=0.3 * pitch, angle=angle, edge=0.22 * pitch)
    return _glass(rng, relief, vessel=rng.random() < 0.5)


def skin(rng: Rng, angle: float) -> Field:
    """Return the long waves of fire-polished glass, which is otherwise smooth."""
    seed, rise = stream(rng), pick_log(rng, 0.004, 0.012)
    return rise * orange_peel(seed, size=11.0)


RECIPES = {
    float_glass: 2.0,
    rippled: 1.7,
    reeded: 0.5,
    pebbled: 1.5,
    frosted: 0.5,
    cut: 0.7,
    pressed: 0.7,
}
SMOOTH = float_glass  # its skin is faint
