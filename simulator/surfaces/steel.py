"""Steel surfaces: brushed, milled, turned, ground, cast, rusty, chequered, knurled."""

from typing import Any

import numpy as np

from simulator.fields import (
    Field,
    arcs,
    diamonds,
    grain,
    lifted,
    mixed,
    orange_peel,
    pits,
    ribs,
    scratches,
    smooth,
    streaks,
    tinted,
    treads,
)
from simulator.noise import Rng, one_of
from simulator.surfaces.base import Surface, pick_log, stream

_STEELS = ((0.56, 0.55, 0.53), (0.62, 0.61, 0.60), (0.45, 0.44, 0.43), (0.52, 0.50, 0.46))
_RUST = np.array([0.22, 0.085, 0.035])


def _metal(relief: Field, colour: Field, roughness: float, **more: Any) -> Surface:
    return Surface(relief, colour, gloss="metal", roughness=roughness, **more)


def brushed(rng: Rng) -> Surface:
    """Return sheet brushed one way: hair-thin long streaks, a stretched highlight."""
    angle, seed, base = rng.uniform(0, np.pi), stream(rng), one_of(_STEELS, rng)
    depth, width = pick_log(rng, 0.010, 0.026), rng.uniform(0.25, 0.5)
    hairs = streaks(seed, angle=angle, width=width, length=60.0)
    colour = tinted(base, 0.07 * hairs)
    return _metal(
        depth * hairs, colour, roughness=rng.uniform(0.12, 0.22), brushing=0.8, angle=angle
    )


def machined(rng: Rng) -> Surface:
    """Return a milled or turned face: evenly spaced tool marks, bent as the cutter was."""
    far, turn = pick_log(rng, 8, 150), rng.uniform(0, 2 * np.pi)
    centre = (far * np.cos(turn), far * np.sin(turn))
    pitch, depth = pick_log(rng, 0.5, 1.3), pick_log(rng, 0.018, 0.045)
    seed, base = stream(rng), one_of(_STEELS, rng)
    marks = arcs(centre=centre, pitch=pitch) + 0.35 * arcs(centre=centre, pitch=pitch * 3.3)
    relief = depth * marks + 0.002 * grain(seed, coarsest=0.6, finest=0.15)
    colour, along = tinted(base, 0.06 * marks), turn + np.pi / 2
    return _metal(relief, colour, roughness=rng.uniform(0.12, 0.25), brushing=0.6, angle=along)


def ground(rng: Rng) -> Surface:
    """Return polished or rolled steel: nearly smooth, scratched by use."""
    seed, base = stream(rng), one_of(_STEELS, rng)
    count, width = int(rng.integers(15, 60)), rng.uniform(0.05, 0.14)
    lines = scratches(seed, count=count, reach=30.0, width=width)
    relief = 0.003 * orange_peel(seed, size=4.0) - 0.02 * lines
    return _metal(relief, tinted(base, -0.25 * lines), roughness=rng.uniform(0.04, 0.16))


def cast(rng: Rng) -> Surface:
    """Return cast, forged or blasted steel: dull and evenly grainy, like a moulded plastic."""
    seed, base = stream(rng), one_of(_STEELS, rng)
    dark, depth = rng.uniform(0.3, 0.8), pick_log(rng, 0.012, 0.05)
    rough = grain(seed, coarsest=rng.uniform(0.8, 1.8), finest=0.15)
    return _metal(
        depth * rough, dark * tinted(base, 0.10 * rough), roughness=rng.uniform(0.3, 0.45)
    )


def rusty(rng: Rng) -> Surface:
    """Return steel that rust has begun to eat: scabs that stand proud, pits between."""
    seed, base = stream(rng), one_of(_STEELS, rng)
    edge, depth = rng.uniform(-0.6, 0.8), pick_log(rng, 0.03, 0.08)
    scabs = smooth(grain(seed, coarsest=14.0, finest=0.6), edge, edge + 0.5)
    crust = 1.0 + 0.6 * grain(seed + 20, coarsest=1.5, finest=0.2)
    holes = pits(seed + 40, size=2.2, radius=0.5, share=0.3)
    shade = 1.0 + 0.35 * grain(seed + 60, coarsest=3.0, finest=0.4)
    bare = tinted(base, Field(lambda x, y: 0 * x))
    colour = lifted(np.clip)(
        mixed(bare, lifted(lambda s: _RUST * s[..., None])(shade), scabs), 0.01, 0.9
    )
    return _metal(depth * (scabs * crust - 0.8 * holes), colour, roughness=rng.uniform(0.3, 0.5))


def chequered(rng: Rng) -> Surface:
    """Return tread plate: lens-shaped bars."""
    angle, seed, base = rng.uniform(0, np.pi), stream(rng), one_of(_STEELS, rng)
    pitch, rise = rng.uniform(7.0, 13.0), rng.uniform(0.35, 0.6)
    skin = 0.006 * grain(seed, coarsest=0.8, finest=0.2)
    relief = rise * treads(pitch=pitch, angle=angle) + skin
    colour = tinted(base, 0.06 * grain(seed + 7, coarsest=6.0, finest=0.5))
    return _metal(relief, colour, roughness=rng.uniform(0.2, 0.35), angle=angle)


def knurled(rng: Rng) -> Surface:
    """Return a knurled grip: small pyramids on a shaft."""
    angle, seed, base = rng.uniform(0, np.pi), stream(rng), one_of(_STEELS, rng)
    pitch, rise = rng.uniform(0.9, 1.8), rng.uniform(0.10, 0.22)
    colour = tinted(base, 0.05 * orange_peel(seed, size=3.0))
    relief = rise * diamonds(pitch=pitch, angle=angle)
    return _metal(relief, colour, roughness=rng.uniform(0.15, 0.25), angle=angle)


def skin(rng: Rng, angle: float) -> Field:
    """Return even tool marks, straight or about a far centre, and scratches across them."""
    seed, pitch = stream(rng), pick_log(rng, 0.45, 0.9)
    depth, count = pick_log(rng, 0.018, 0.032), int(rng.integers(15, 45))
    far = (150.0 * np.sin(angle), -150.0 * np.cos(angle))
    straight = rng.random() < 0.6
    marks = (
        2.0 * ribs(angle=angle, pitch=pitch) - 1.0 if straight else arcs(centre=far, pitch=pitch)
    )
    return depth * marks - 0.05 * scratches(seed, count=count, reach=40.0, width=0.12)


RECIPES = {
    brushed: 2.0,
    machined: 1.5,
    ground: 1.2,
    cast: 0.6,
    rusty: 0.6,
    chequered: 0.5,
    knurled: 0.6,
}
SMOOTH = ground  # its skin is faint
