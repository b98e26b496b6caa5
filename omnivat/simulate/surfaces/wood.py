"""Wooden surfaces: sawn, sanded, planed with rings, weathered, varnished, end grain."""

import numpy as np

from omnivat.simulate.noise import Array, smoothstep, turned
from omnivat.simulate.surfaces.base import (
    Surface,
    arcs,
    grain,
    orange_peel,
    pick,
    pick_log,
    ribs,
    streaks,
    stream,
    tinted,
)

_SPECIES = (  # linear reflectance of early wood; late wood is darker
    (0.62, 0.44, 0.27),
    (0.50, 0.31, 0.16),
    (0.36, 0.19, 0.09),
    (0.19, 0.10, 0.055),
    (0.68, 0.54, 0.38),
    (0.44, 0.22, 0.12),
)


class _Grain:
    """Year rings, fibres and pores of one board, shared by its relief and its colour."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.angle = pick(rng, 0, np.pi)
        self.pitch = pick_log(rng, 2.0, 9.0)
        self.wave = stream(rng)
        self.fibre = stream(rng)
        self.pore = stream(rng)
        self.species = _SPECIES[rng.integers(len(_SPECIES))]
        self.contrast = pick(rng, 0.25, 0.6)

    def rings(self, x: Array, y: Array) -> Array:
        """Return late wood as 1, early wood as 0."""
        _, v = turned(x, y, self.angle)
        bend = streaks(x, y, angle=self.angle, width=4 * self.pitch, length=60 * self.pitch, seed=self.wave)
        phase = v / self.pitch + 0.9 * bend
        saw = phase - np.floor(phase)
        return smoothstep(saw, 0.25, 0.9) * (1.0 - smoothstep(saw, 0.93, 1.0))

    def fibres(self, x: Array, y: Array) -> Array:
        """Return fine streaks along the grain, unit spread."""
        return streaks(x, y, angle=self.angle, width=0.9, length=25.0, seed=self.fibre)

    def pores(self, x: Array, y: Array) -> Array:
        """Return 1 in the short open vessels."""
        field = streaks(x, y, angle=self.angle, width=0.55, length=7.0, seed=self.pore)
        return smoothstep(field, 1.2, 1.9)

    def colour(self, x: Array, y: Array) -> Array:
        """Return reflectance (..., 3)."""
        shade = -self.contrast * self.rings(x, y) + 0.10 * self.fibres(x, y)
        return tinted(self.species, shade - 0.45 * self.pores(x, y))


def sawn(rng: np.random.Generator) -> Surface:
    """Return rough lumber: fibres torn up, and the teeth of the saw across them."""
    wood, saw_pitch = _Grain(rng), pick(rng, 0.9, 2.6)
    lean = wood.angle + np.pi / 2 + pick(rng, -0.3, 0.3)
    rough, teeth = pick(rng, 0.03, 0.07), pick(rng, 0.02, 0.06)
    seed = stream(rng)

    def relief(x: Array, y: Array) -> Array:
        torn = grain(x, y, coarsest=1.2, finest=0.15, seed=seed)
        fibres = wood.fibres(x, y) - 1.4 * wood.pores(x, y)
        return rough * fibres + 0.4 * rough * torn + teeth * ribs(x, y, angle=lean, pitch=saw_pitch)

    return Surface(
        recipe="sawn", relief=relief, colour=wood.colour, gloss="matte",
        roughness=0.6, angle=wood.angle,
    )  # fmt: skip


def _bare(rng: np.random.Generator, name: str, fibre: float, ring: float, pore: float) -> Surface:
    """Return bare wood whose fibres, rings and pores stand out by so many mm."""
    wood = _Grain(rng)
    scale = pick_log(rng, 0.6, 1.6)

    def relief(x: Array, y: Array) -> Array:
        raised = fibre * wood.fibres(x, y) + ring * wood.rings(x, y)
        return scale * (raised - pore * wood.pores(x, y))

    return Surface(
        recipe=name, relief=relief, colour=wood.colour, gloss="matte",
        roughness=0.5, angle=wood.angle,
    )  # fmt: skip


def sanded(rng: np.random.Generator) -> Surface:
    """Return sanded wood: faint fibres and open pores."""
    return _bare(rng, "sanded", fibre=0.020, ring=0.025, pore=0.08)


def ringed(rng: np.random.Generator) -> Surface:
    """Return planed softwood whose late wood stands proud."""
    return _bare(rng, "ringed", fibre=0.020, ring=0.14, pore=0.05)


def weathered(rng: np.random.Generator) -> Surface:
    """Return wood left outside: grey, deeply furrowed along the grain."""
    bare = _bare(rng, "weathered", fibre=0.055, ring=0.14, pore=0.12)
    grey = np.array([0.34, 0.31, 0.27])

    def colour(x: Array, y: Array) -> Array:
        brown = bare.colour(x, y)
        faded = grey * (0.4 + 1.6 * brown.mean(-1, keepdims=True))
        return np.asarray(0.45 * brown + 0.55 * faded)

    return Surface(
        recipe="weathered", relief=bare.relief, colour=colour, gloss="matte",
        roughness=0.6, angle=bare.angle,
    )  # fmt: skip


def varnished(rng: np.random.Generator) -> Surface:
    """Return furniture: grain under a coat that almost levels it."""
    wood, coat = _Grain(rng), stream(rng)
    left, soft = pick(rng, 0.008, 0.018), pick(rng, 0.003, 0.006)

    def relief(x: Array, y: Array) -> Array:
        under = wood.fibres(x, y) - 2.5 * wood.pores(x, y)
        return left * under + soft * orange_peel(x, y, size=2.5, seed=coat)

    return Surface(
        recipe="varnished", relief=relief, colour=wood.colour, gloss="coated",
        roughness=pick(rng, 0.08, 0.25), angle=wood.angle,
    )  # fmt: skip


def end_grain(rng: np.random.Generator) -> Surface:
    """Return a cross-cut: year rings as circles, radial checks, saw marks."""
    wood, seed = _Grain(rng), stream(rng)
    centre = (pick(rng, -25, 25), pick(rng, -25, 25))
    pitch, saw = pick(rng, 2.0, 4.5), pick(rng, 0.01, 0.04)

    def rings(x: Array, y: Array) -> Array:
        warp = 1.0 + 0.03 * orange_peel(x, y, size=20.0, seed=seed)
        return smoothstep(arcs(x * warp, y * warp, centre=centre, pitch=pitch), -0.4, 0.8)

    def relief(x: Array, y: Array) -> Array:
        torn = grain(x, y, coarsest=0.8, finest=0.15, seed=seed + 1)
        marks = ribs(x, y, angle=wood.angle, pitch=1.7)
        return 0.05 * rings(x, y) + 0.022 * torn + saw * marks

    def colour(x: Array, y: Array) -> Array:
        speckle = 0.10 * grain(x, y, coarsest=0.8, finest=0.2, seed=seed + 1)
        return tinted(wood.species, -0.5 * rings(x, y) + speckle)

    return Surface(
        recipe="end grain", relief=relief, colour=colour, gloss="matte",
        roughness=0.6, angle=wood.angle,
    )  # fmt: skip


RECIPES = {
    sawn: 1.3, sanded: 1.8, ringed: 1.6, weathered: 1.2, varnished: 1.2, end_grain: 0.3,
}  # fmt: skip
