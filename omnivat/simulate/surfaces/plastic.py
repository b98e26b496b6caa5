"""Plastic surfaces: mould grain, leather grain, ribs, dots, gloss, printed layers."""

import numpy as np

from omnivat.simulate.noise import Array, cells, smoothstep
from omnivat.simulate.surfaces.base import (
    Surface,
    dots,
    grain,
    orange_peel,
    pick,
    pick_log,
    ribs,
    scratches,
    stream,
    tinted,
)


def _dye(rng: np.random.Generator) -> tuple[float, float, float]:
    """Return a colour that plastics have: strong, white, grey or black."""
    kind = rng.random()
    if kind < 0.75:
        strong = rng.permutation(np.array([pick(rng, 0.35, 0.8), pick(rng, 0.03, 0.45), 0.04]))
        return (float(strong[0]), float(strong[1]), float(strong[2]))
    level = pick_log(rng, 0.02, 0.8)
    warm = pick(rng, -0.06, 0.06)
    return (level * (1 + warm), level, level * (1 - warm))


def _even(rng: np.random.Generator) -> tuple[tuple[float, float, float], int]:
    return _dye(rng), stream(rng)


def eroded(rng: np.random.Generator) -> Surface:
    """Return the spark-eroded mould grain of housings: even, fine and matt."""
    dye, seed = _even(rng)
    depth, size = pick_log(rng, 0.022, 0.05), pick(rng, 0.6, 1.1)
    return Surface(
        recipe="eroded",
        relief=lambda x, y: depth * grain(x, y, coarsest=size, finest=0.2, seed=seed),
        colour=lambda x, y: tinted(dye, 0.03 * grain(x, y, coarsest=size, finest=0.3, seed=seed)),
        gloss="coated", roughness=pick(rng, 0.3, 0.5),
    )  # fmt: skip


def leather_grain(rng: np.random.Generator) -> Surface:
    """Return etched leather grain: small cushions between creases."""
    dye, seed = _even(rng)
    size, depth = pick(rng, 1.4, 2.8), pick(rng, 0.08, 0.18)

    def cushions(x: Array, y: Array) -> Array:
        _, border = cells(x, y, size=size, seed=seed)
        return smoothstep(border, 0.0, 0.35 * size)

    return Surface(
        recipe="leather grain",
        relief=lambda x, y: depth * cushions(x, y),
        colour=lambda x, y: tinted(dye, 0.10 * (cushions(x, y) - 1.0)),
        gloss="coated", roughness=pick(rng, 0.25, 0.45),
    )  # fmt: skip


def ribbed(rng: np.random.Generator) -> Surface:
    """Return grip ribs: rounded, parallel, well raised."""
    dye, seed = _even(rng)
    angle, pitch, rise = pick(rng, 0, np.pi), pick(rng, 1.8, 4.5), pick(rng, 0.2, 0.5)
    sharp = pick(rng, 0.6, 2.0)

    def relief(x: Array, y: Array) -> Array:
        skin = grain(x, y, coarsest=0.8, finest=0.2, seed=seed)
        return rise * ribs(x, y, angle=angle, pitch=pitch, sharpness=sharp) + 0.006 * skin

    return Surface(
        recipe="ribbed", relief=relief,
        colour=lambda x, y: tinted(dye, 0.02 * orange_peel(x, y, size=8.0, seed=seed)),
        gloss="coated", roughness=pick(rng, 0.15, 0.4), angle=angle,
    )  # fmt: skip


def studded(rng: np.random.Generator) -> Surface:
    """Return rows of round grip pads."""
    dye, seed = _even(rng)
    angle, pitch, rise = pick(rng, 0, np.pi), pick(rng, 2.5, 6.5), pick(rng, 0.15, 0.4)
    radius = pitch * pick(rng, 0.2, 0.33)

    def relief(x: Array, y: Array) -> Array:
        pads = dots(x, y, pitch=pitch, radius=radius, angle=angle, edge=0.25)
        return rise * pads + 0.004 * grain(x, y, coarsest=0.7, finest=0.2, seed=seed)

    return Surface(
        recipe="studded", relief=relief,
        colour=lambda x, y: tinted(dye, 0.02 * orange_peel(x, y, size=8.0, seed=seed)),
        gloss="coated", roughness=pick(rng, 0.2, 0.4), angle=angle,
    )  # fmt: skip


def glossy(rng: np.random.Generator) -> Surface:
    """Return injection-moulded gloss: flow waves and the scratches of use."""
    dye, seed = _even(rng)
    wave, count = pick(rng, 0.003, 0.008), int(rng.integers(4, 20))

    def relief(x: Array, y: Array) -> Array:
        used = scratches(x, y, count=count, reach=30.0, width=0.10, seed=seed + 5)
        return wave * orange_peel(x, y, size=6.0, seed=seed) - 0.015 * used

    return Surface(
        recipe="glossy", relief=relief,
        colour=lambda x, y: tinted(dye, 0.02 * orange_peel(x, y, size=15.0, seed=seed)),
        gloss="coated", roughness=pick(rng, 0.04, 0.15),
    )  # fmt: skip


def printed(rng: np.random.Generator) -> Surface:
    """Return a 3-D print: layer lines, slightly uneven."""
    dye, seed = _even(rng)
    angle, pitch, rise = pick(rng, 0, np.pi), pick(rng, 0.45, 0.9), pick(rng, 0.025, 0.06)

    def lines(x: Array, y: Array) -> Array:
        wander = 0.12 * pitch * orange_peel(x, y, size=10.0, seed=seed)
        return ribs(x + wander, y + wander, angle=angle, pitch=pitch, sharpness=0.7)

    return Surface(
        recipe="printed",
        relief=lambda x, y: rise * lines(x, y),
        colour=lambda x, y: tinted(dye, 0.12 * (lines(x, y) - 0.5)),
        gloss="coated", roughness=pick(rng, 0.2, 0.35), brushing=0.4, angle=angle,
    )  # fmt: skip


RECIPES = {
    eroded: 1.6, leather_grain: 1.3, ribbed: 1.1, studded: 1.2, glossy: 1.3, printed: 0.7,
}  # fmt: skip
