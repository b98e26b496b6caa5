"""Ceramic surfaces: glazed, crazed, speckled stoneware, terracotta, thrown, tiled, carved."""

import numpy as np

from simulator.fields import (
    Field,
    arcs,
    cracks,
    grain,
    mixed,
    orange_peel,
    pits,
    ribs,
    smooth,
    tiles,
    tinted,
)
from simulator.noise import Rng, one_of
from simulator.surfaces.base import Surface, pick_log, stream

_GLAZES = (
    (0.78, 0.76, 0.70), (0.82, 0.82, 0.80), (0.42, 0.55, 0.46), (0.12, 0.22, 0.42),
    (0.30, 0.14, 0.07), (0.60, 0.62, 0.58), (0.16, 0.32, 0.34),
)  # fmt: skip
_CLAYS = ((0.52, 0.24, 0.13), (0.46, 0.38, 0.28), (0.34, 0.27, 0.21), (0.60, 0.50, 0.38))


def glazed(rng: Rng) -> Surface:
    """Return a glossy glaze: soft waves and pinholes."""
    glaze, seed = one_of(_GLAZES, rng), stream(rng)
    wave, holes = rng.uniform(0.016, 0.030), rng.uniform(0.15, 0.4)
    pinholes = pits(seed + 4, size=3.0, radius=0.35, share=holes)
    relief = wave * orange_peel(seed, size=3.5) - 0.07 * pinholes
    colour = tinted(glaze, 0.06 * orange_peel(seed + 1, size=16.0) - 0.4 * pinholes)
    return Surface(relief, colour, gloss="coated", roughness=rng.uniform(0.02, 0.07))


def crazed(rng: Rng) -> Surface:
    """Return a glaze with a net of cracks, stained dark."""
    glaze, seed = one_of(_GLAZES, rng), stream(rng)
    size, stain = rng.uniform(3.0, 5.5), rng.uniform(0.4, 0.8)
    relief = 0.012 * orange_peel(seed + 5, size=5.0) - 0.07 * cracks(seed, size=size, width=0.22)
    colour = tinted(glaze, -stain * cracks(seed, size=size, width=0.28))
    return Surface(relief, colour, gloss="coated", roughness=rng.uniform(0.02, 0.06))


def stoneware(rng: Rng) -> Surface:
    """Return a satin glaze with iron specks over gritty clay."""
    glaze, seed = one_of(_GLAZES, rng), stream(rng)
    specks = pits(seed + 2, size=2.0, radius=0.42, share=0.35)
    relief = rng.uniform(0.02, 0.04) * grain(seed, coarsest=2.4, finest=0.4) + 0.05 * specks
    satin = tinted(glaze, 0.04 * grain(seed, coarsest=4.0, finest=0.8))
    colour = mixed(satin, np.array([0.10, 0.06, 0.04]), specks)
    return Surface(relief, colour, gloss="coated", roughness=rng.uniform(0.12, 0.25))


def terracotta(rng: Rng) -> Surface:
    """Return unglazed clay: gritty, pitted, dull."""
    clay, seed = one_of(_CLAYS, rng), stream(rng)
    rough = grain(seed, coarsest=1.6, finest=0.2)
    holes = pits(seed + 30, size=1.8, radius=0.55, share=0.35)
    relief = pick_log(rng, 0.02, 0.05) * rough - 0.12 * holes
    return Surface(relief, tinted(clay, 0.09 * rough), gloss="matte", roughness=0.6)


def thrown(rng: Rng) -> Surface:
    """Return the ridges that fingers leave on the wheel, glazed over or bare."""
    seed, bare = stream(rng), rng.random() < 0.4
    base = one_of(_CLAYS if bare else _GLAZES, rng)
    angle, pitch, rise = rng.uniform(0, np.pi), rng.uniform(3.0, 7.0), rng.uniform(0.08, 0.22)
    ridges = ribs(angle=angle, pitch=pitch, sharpness=1.2).moved(
        0.22 * pitch * orange_peel(seed, size=12.0)
    )
    grit = (0.022 if bare else 0.006) * grain(seed + 11, coarsest=1.4, finest=0.25)
    colour = tinted(base, 0.14 * (ridges - 0.5))
    rough = 0.6 if bare else rng.uniform(0.03, 0.12)
    relief = rise * ridges + grit
    return Surface(
        relief, colour, gloss="matte" if bare else "coated", roughness=rough, angle=angle
    )


def tiled(rng: Rng) -> Surface:
    """Return mosaic: small glazed tiles and sandy joints."""
    seed, glaze = stream(rng), one_of(_GLAZES, rng)
    angle, pitch, joint = rng.uniform(0, np.pi), rng.uniform(9.0, 18.0), rng.uniform(1.2, 2.2)
    face = tiles(pitch=pitch, joint=joint, angle=angle)
    sand = 0.03 * grain(seed, coarsest=0.8, finest=0.2)
    top = 0.5 + 0.012 * orange_peel(seed + 6, size=5.0)
    mortar = Field(lambda x, y: np.array([0.5, 0.48, 0.44]) * np.ones((*np.shape(x), 1)))
    colour = mixed(mortar, tinted(glaze, 0.05 * orange_peel(seed + 3, size=12.0)), face)
    relief = face * top + (1 - face) * sand
    return Surface(relief, colour, gloss="coated", roughness=rng.uniform(0.03, 0.10), angle=angle)


def carved(rng: Rng) -> Surface:
    """Return rings carved or pressed into clay and flooded with glaze that pools in them."""
    seed, glaze = stream(rng), one_of(_GLAZES, rng)
    centre = (rng.uniform(-20, 20), rng.uniform(-20, 20))
    pitch, rise = rng.uniform(3.5, 6.5), rng.uniform(0.10, 0.22)
    waves = smooth(arcs(centre=centre, pitch=pitch), -0.6, 0.6)
    relief = rise * waves + 0.01 * orange_peel(seed, size=4.0)
    colour = tinted(glaze, 0.35 * (waves - 0.8))
    return Surface(relief, colour, gloss="coated", roughness=rng.uniform(0.03, 0.1))


def skin(rng: Rng, angle: float) -> Field:
    """Return a wavy glaze, grains of grit under it, and pinholes."""
    seed, wave = stream(rng), pick_log(rng, 0.03, 0.06)
    bump, holes = pick_log(rng, 0.07, 0.13), rng.uniform(0.15, 0.35)
    grit = pits(seed + 3, size=2.6, radius=0.55, share=0.35)
    open_ = pits(seed + 9, size=2.2, radius=0.30, share=holes)
    return wave * orange_peel(seed, size=4.5) + bump * grit - 0.08 * open_


RECIPES = {
    glazed: 2.0,
    crazed: 1.3,
    stoneware: 1.5,
    terracotta: 1.2,
    thrown: 0.8,
    tiled: 0.4,
    carved: 0.4,
}
SMOOTH = glazed  # its skin is faint
