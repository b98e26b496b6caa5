"""Plastic surfaces: mould grain, leather grain, ribs, dots, gloss, printed layers."""

from typing import Any

import numpy as np

from simulator.fields import (
    Field,
    borders,
    dots,
    field,
    grain,
    orange_peel,
    ribs,
    scratches,
    smooth,
    tinted,
)
from simulator.noise import Array, Colour, Rng, smoothstep, turned
from simulator.surfaces.base import Surface, pick_log, stream


def _dye(rng: Rng) -> Colour:
    """Return a colour that plastics have: strong, white, grey or black."""
    if rng.random() < 0.75:
        return rng.permutation([rng.uniform(0.35, 0.8), rng.uniform(0.03, 0.45), 0.04])
    level, warm = pick_log(rng, 0.02, 0.8), rng.uniform(-0.06, 0.06)
    return (level * (1 + warm), level, level * (1 - warm))


def _moulded(relief: Field, dye: Colour, shade: Field, roughness: float, **more: Any) -> Surface:
    return Surface(relief, tinted(dye, shade), gloss="coated", roughness=roughness, **more)


def eroded(rng: Rng) -> Surface:
    """Return the spark-eroded mould grain of housings: even, fine and matt."""
    dye, seed = _dye(rng), stream(rng)
    depth, size = pick_log(rng, 0.022, 0.05), rng.uniform(0.6, 1.1)
    tooth, shade = (grain(seed, coarsest=size, finest=finest) for finest in (0.2, 0.3))
    return _moulded(depth * tooth, dye, 0.03 * shade, roughness=rng.uniform(0.3, 0.5))


def leather_grain(rng: Rng) -> Surface:
    """Return etched leather grain: small cushions between creases."""
    dye, seed = _dye(rng), stream(rng)
    size, depth = rng.uniform(1.4, 2.8), rng.uniform(0.08, 0.18)
    cushions = smooth(borders(seed, size=size), 0.0, 0.35 * size)
    return _moulded(
        depth * cushions, dye, 0.10 * (cushions - 1.0), roughness=rng.uniform(0.25, 0.45)
    )


def ribbed(rng: Rng) -> Surface:
    """Return grip ribs: rounded, parallel, well raised."""
    dye, seed = _dye(rng), stream(rng)
    angle, pitch, rise = rng.uniform(0, np.pi), rng.uniform(1.8, 4.5), rng.uniform(0.2, 0.5)
    skin = 0.006 * grain(seed, coarsest=0.8, finest=0.2)
    relief = rise * ribs(angle=angle, pitch=pitch, sharpness=rng.uniform(0.6, 2.0)) + skin
    shade = 0.02 * orange_peel(seed, size=8.0)
    return _moulded(relief, dye, shade, roughness=rng.uniform(0.15, 0.4), angle=angle)


def studded(rng: Rng) -> Surface:
    """Return rows of round grip pads."""
    dye, seed = _dye(rng), stream(rng)
    angle, pitch, rise = rng.uniform(0, np.pi), rng.uniform(2.5, 6.5), rng.uniform(0.15, 0.4)
    skin = 0.004 * grain(seed, coarsest=0.7, finest=0.2)
    relief = (
        rise * dots(pitch=pitch, radius=pitch * rng.uniform(0.2, 0.33), angle=angle, edge=0.25)
        + skin
    )
    shade = 0.02 * orange_peel(seed, size=8.0)
    return _moulded(relief, dye, shade, roughness=rng.uniform(0.2, 0.4), angle=angle)


def glossy(rng: Rng) -> Surface:
    """Return injection-moulded gloss: flow waves and the scratches of use."""
    dye, seed = _dye(rng), stream(rng)
    wave, count = rng.uniform(0.003, 0.008), int(rng.integers(4, 20))
    used = scratches(seed + 5, count=count, reach=30.0, width=0.10)
    relief = wave * orange_peel(seed, size=6.0) - 0.015 * used
    return _moulded(
        relief, dye, 0.02 * orange_peel(seed, size=15.0), roughness=rng.uniform(0.04, 0.15)
    )


def printed(rng: Rng) -> Surface:
    """Return a 3-D print: layer lines, slightly uneven."""
    dye, seed = _dye(rng), stream(rng)
    angle, pitch, rise = rng.uniform(0, np.pi), rng.uniform(0.45, 0.9), rng.uniform(0.025, 0.06)
    lines = ribs(angle=angle, pitch=pitch, sharpness=0.7).moved(
        0.12 * pitch * orange_peel(seed, size=10.0)
    )
    shade = 0.12 * (lines - 0.5)
    return _moulded(
        rise * lines, dye, shade, roughness=rng.uniform(0.2, 0.35), brushing=0.4, angle=angle
    )


def skin(rng: Rng, angle: float) -> Field:
    """Return even mould texture, sink marks, and the parting lines of the mould."""
    seed, texture = stream(rng), pick_log(rng, 0.020, 0.034)
    size, turn = rng.uniform(0.5, 0.9), rng.uniform(0, np.pi)
    apart, high = rng.uniform(9.0, 24.0), rng.uniform(0.07, 0.14)

    @field
    def parting(x: Array, y: Array) -> Array:
        across = turned(x, y, turn)[1]
        return 1.0 - smoothstep(
            np.abs(across / apart - np.round(across / apart)) * apart, 0.08, 0.28
        )

    sunk = 0.02 * orange_peel(seed + 5, size=14.0)
    return texture * grain(seed, coarsest=size, finest=0.25) + sunk + high * parting()


RECIPES = {eroded: 1.6, leather_grain: 1.3, ribbed: 1.1, studded: 1.2, glossy: 1.3, printed: 0.7}
SMOOTH = glossy  # its skin is faint
