"""Wooden surfaces: sawn, sanded, planed with rings, weathered, varnished, end grain."""

from dataclasses import replace

import numpy as np

from simulator.fields import (
    Field,
    arcs,
    field,
    grain,
    lifted,
    orange_peel,
    ribs,
    smooth,
    streaks,
    tinted,
)
from simulator.noise import Array, Rng, one_of, smoothstep, turned
from simulator.surfaces.base import Surface, pick_log, stream

_SPECIES = (  # linear reflectance of early wood; late wood is darker
    (0.62, 0.44, 0.27), (0.50, 0.31, 0.16), (0.36, 0.19, 0.09), (0.19, 0.10, 0.055),
    (0.68, 0.54, 0.38), (0.44, 0.22, 0.12),
)  # fmt: skip


class _Grain:
    """Year rings (late wood 1, early wood 0), fibres and pores of one board, shared by its
    relief and its colour.
    """

    def __init__(self, rng: Rng) -> None:
        self.angle, pitch = rng.uniform(0, np.pi), pick_log(rng, 2.0, 9.0)
        wave, fibre, pore = stream(rng), stream(rng), stream(rng)
        self.species = one_of(_SPECIES, rng)
        bend = streaks(wave, angle=self.angle, width=4 * pitch, length=60 * pitch)
        self.rings = _late(self.angle, pitch, bend)
        self.fibres = streaks(fibre, angle=self.angle, width=0.9, length=25.0)
        self.pores = smooth(streaks(pore, angle=self.angle, width=0.55, length=7.0), 1.2, 1.9)
        shade = -rng.uniform(0.25, 0.6) * self.rings + 0.10 * self.fibres
        self.colour = tinted(self.species, shade - 0.45 * self.pores)

    def surface(self, relief: Field, *, roughness: float) -> Surface:
        """Return bare wood with this relief."""
        return Surface(relief, self.colour, gloss="matte", roughness=roughness, angle=self.angle)


@field
def _late(x: Array, y: Array, angle: float, pitch: float, bend: Field) -> Array:
    phase = turned(x, y, angle)[1] / pitch + 0.9 * bend(x, y)
    saw = phase - np.floor(phase)
    return smoothstep(saw, 0.25, 0.9) * (1.0 - smoothstep(saw, 0.93, 1.0))


def sawn(rng: Rng) -> Surface:
    """Return rough lumber: fibres torn up, and the teeth of the saw across them."""
    wood, saw_pitch = _Grain(rng), rng.uniform(0.9, 2.6)
    lean = wood.angle + np.pi / 2 + rng.uniform(-0.3, 0.3)
    rough, teeth = rng.uniform(0.03, 0.07), rng.uniform(0.02, 0.06)
    torn = grain(stream(rng), coarsest=1.2, finest=0.15)
    relief = (
        rough * (wood.fibres - 1.4 * wood.pores)
        + 0.4 * rough * torn
        + teeth * ribs(angle=lean, pitch=saw_pitch)
    )
    return wood.surface(relief, roughness=0.6)


def _bare(rng: Rng, fibre: float, ring: float, pore: float) -> Surface:
    """Return bare wood whose fibres, rings and pores stand out by so many mm."""
    wood = _Grain(rng)
    raised = fibre * wood.fibres + ring * wood.rings
    return wood.surface(pick_log(rng, 0.6, 1.6) * (raised - pore * wood.pores), roughness=0.5)


def sanded(rng: Rng) -> Surface:
    """Return sanded wood: faint fibres and open pores."""
    return _bare(rng, fibre=0.020, ring=0.025, pore=0.08)


def ringed(rng: Rng) -> Surface:
    """Return planed softwood whose late wood stands proud."""
    return _bare(rng, fibre=0.020, ring=0.14, pore=0.05)


def weathered(rng: Rng) -> Surface:
    """Return wood left outside: grey, deeply furrowed along the grain."""
    bare = _bare(rng, fibre=0.055, ring=0.14, pore=0.12)

    def faded(brown: Array) -> Array:
        grey = np.array([0.34, 0.31, 0.27]) * (0.4 + 1.6 * brown.mean(-1, keepdims=True))
        return 0.45 * brown + 0.55 * grey

    return replace(bare, colour=lifted(faded)(bare.colour), roughness=0.6)


def varnished(rng: Rng) -> Surface:
    """Return furniture: grain under a coat that almost levels it."""
    wood, coat = _Grain(rng), stream(rng)
    left, soft = rng.uniform(0.008, 0.018), rng.uniform(0.003, 0.006)
    relief = left * (wood.fibres - 2.5 * wood.pores) + soft * orange_peel(coat, size=2.5)
    return replace(wood.surface(relief, roughness=rng.uniform(0.08, 0.25)), gloss="coated")


def end_grain(rng: Rng) -> Surface:
    """Return a cross-cut: year rings as circles, radial checks, saw marks."""
    wood, seed = _Grain(rng), stream(rng)
    centre = (rng.uniform(-25, 25), rng.uniform(-25, 25))
    pitch, saw = rng.uniform(2.0, 4.5), rng.uniform(0.01, 0.04)
    even, warp = arcs(centre=centre, pitch=pitch), 1.0 + 0.03 * orange_peel(seed, size=20.0)
    rings = smooth(Field(lambda x, y: even(x * (bent := warp(x, y)), y * bent)), -0.4, 0.8)
    torn = 0.022 * grain(seed + 1, coarsest=0.8, finest=0.15)
    relief = 0.05 * rings + torn + saw * ribs(angle=wood.angle, pitch=1.7)
    colour = tinted(wood.species, -0.5 * rings + 0.10 * grain(seed + 1, coarsest=0.8, finest=0.2))
    return replace(wood.surface(relief, roughness=0.6), colour=colour)


def skin(rng: Rng, angle: float) -> Field:
    """Return fibres, and pores as short open slits along the grain."""
    seed, fibre, pore = stream(rng), pick_log(rng, 0.018, 0.035), pick_log(rng, 0.07, 0.13)
    width, length, level = rng.uniform(0.35, 0.6), rng.uniform(3.0, 6.0), rng.uniform(0.9, 1.3)
    fibres = streaks(seed, angle=angle, width=0.7, length=22.0)
    slits = streaks(seed + 7, angle=angle, width=width, length=length)
    return fibre * fibres - pore * smooth(slits, level, level + 0.6)


RECIPES = {sawn: 1.3, sanded: 1.8, ringed: 1.6, weathered: 1.2, varnished: 1.2, end_grain: 0.3}
SMOOTH = varnished  # its skin is faint
