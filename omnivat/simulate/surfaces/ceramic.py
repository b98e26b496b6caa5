"""Ceramic surfaces: glazed, crazed, speckled stoneware, terracotta, thrown, tiled, carved."""

import numpy as np

from omnivat.simulate.noise import Array, smoothstep
from omnivat.simulate.surfaces.base import (
    Surface,
    arcs,
    cracks,
    grain,
    mixed,
    orange_peel,
    pick,
    pick_log,
    pits,
    ribs,
    stream,
    tiles,
    tinted,
)

_GLAZES = (
    (0.78, 0.76, 0.70),
    (0.82, 0.82, 0.80),
    (0.42, 0.55, 0.46),
    (0.12, 0.22, 0.42),
    (0.30, 0.14, 0.07),
    (0.60, 0.62, 0.58),
    (0.16, 0.32, 0.34),
)
_CLAYS = ((0.52, 0.24, 0.13), (0.46, 0.38, 0.28), (0.34, 0.27, 0.21), (0.60, 0.50, 0.38))


def _glaze(rng: np.random.Generator) -> tuple[float, float, float]:
    return _GLAZES[rng.integers(len(_GLAZES))]


def _clay(rng: np.random.Generator) -> tuple[float, float, float]:
    return _CLAYS[rng.integers(len(_CLAYS))]


def glazed(rng: np.random.Generator) -> Surface:
    """Return a glossy glaze: soft waves and pinholes."""
    glaze, seed = _glaze(rng), stream(rng)
    wave, holes = pick(rng, 0.016, 0.030), pick(rng, 0.15, 0.4)

    def pinholes(x: Array, y: Array) -> Array:
        return pits(x, y, size=3.0, radius=0.35, share=holes, seed=seed + 4)

    return Surface(
        recipe="glazed",
        relief=lambda x, y: wave * orange_peel(x, y, size=3.5, seed=seed) - 0.07 * pinholes(x, y),
        colour=lambda x, y: tinted(
            glaze, 0.06 * orange_peel(x, y, size=16.0, seed=seed + 1) - 0.4 * pinholes(x, y)),
        gloss="coated", roughness=pick(rng, 0.02, 0.07),
    )  # fmt: skip


def crazed(rng: np.random.Generator) -> Surface:
    """Return a glaze with a net of cracks, stained dark."""
    glaze, seed = _glaze(rng), stream(rng)
    size, stain = pick(rng, 3.0, 5.5), pick(rng, 0.4, 0.8)

    def net(x: Array, y: Array, width: float) -> Array:
        return cracks(x, y, size=size, width=width, seed=seed)

    def relief(x: Array, y: Array) -> Array:
        return 0.012 * orange_peel(x, y, size=5.0, seed=seed + 5) - 0.07 * net(x, y, 0.22)

    return Surface(
        recipe="crazed", relief=relief,
        colour=lambda x, y: tinted(glaze, -stain * net(x, y, 0.28)),
        gloss="coated", roughness=pick(rng, 0.02, 0.06),
    )  # fmt: skip


def stoneware(rng: np.random.Generator) -> Surface:
    """Return a satin glaze with iron specks over gritty clay."""
    glaze, seed = _glaze(rng), stream(rng)
    grit = pick(rng, 0.02, 0.04)

    def specks(x: Array, y: Array) -> Array:
        return pits(x, y, size=2.0, radius=0.42, share=0.35, seed=seed + 2)

    def relief(x: Array, y: Array) -> Array:
        rough = grain(x, y, coarsest=2.4, finest=0.4, seed=seed)
        return grit * rough + 0.05 * specks(x, y)

    return Surface(
        recipe="stoneware", relief=relief,
        colour=lambda x, y: mixed(
            tinted(glaze, 0.04 * grain(x, y, coarsest=4.0, finest=0.8, seed=seed)),
            np.array([0.10, 0.06, 0.04]), specks(x, y)),
        gloss="coated", roughness=pick(rng, 0.12, 0.25),
    )  # fmt: skip


def terracotta(rng: np.random.Generator) -> Surface:
    """Return unglazed clay: gritty, pitted, dull."""
    clay, seed = _clay(rng), stream(rng)
    grit = pick_log(rng, 0.02, 0.05)

    def rough(x: Array, y: Array) -> Array:
        return grain(x, y, coarsest=1.6, finest=0.2, seed=seed)

    def relief(x: Array, y: Array) -> Array:
        holes = pits(x, y, size=1.8, radius=0.55, share=0.35, seed=seed + 30)
        return grit * rough(x, y) - 0.12 * holes

    return Surface(
        recipe="terracotta", relief=relief,
        colour=lambda x, y: tinted(clay, 0.09 * rough(x, y)),
        gloss="matte", roughness=0.6,
    )  # fmt: skip


def thrown(rng: np.random.Generator) -> Surface:
    """Return the ridges that fingers leave on the wheel, glazed over or bare."""
    seed, bare = stream(rng), rng.random() < 0.4
    base = _clay(rng) if bare else _glaze(rng)
    angle, pitch, rise = pick(rng, 0, np.pi), pick(rng, 3.0, 7.0), pick(rng, 0.08, 0.22)
    grit = 0.022 if bare else 0.006

    def ridges(x: Array, y: Array) -> Array:
        wander = 0.22 * pitch * orange_peel(x, y, size=12.0, seed=seed)
        return ribs(x + wander, y + wander, angle=angle, pitch=pitch, sharpness=1.2)

    return Surface(
        recipe="thrown",
        relief=lambda x, y: rise * ridges(x, y) + grit * grain(
            x, y, coarsest=1.4, finest=0.25, seed=seed + 11),
        colour=lambda x, y: tinted(base, 0.14 * (ridges(x, y) - 0.5)),
        gloss="matte" if bare else "coated", roughness=0.6 if bare else pick(rng, 0.03, 0.12),
        angle=angle,
    )  # fmt: skip


def tiled(rng: np.random.Generator) -> Surface:
    """Return mosaic: small glazed tiles and sandy joints."""
    seed, glaze = stream(rng), _glaze(rng)
    angle, pitch, joint = pick(rng, 0, np.pi), pick(rng, 9.0, 18.0), pick(rng, 1.2, 2.2)

    def face(x: Array, y: Array) -> Array:
        return tiles(x, y, pitch=pitch, joint=joint, angle=angle)

    def relief(x: Array, y: Array) -> Array:
        sand = 0.03 * grain(x, y, coarsest=0.8, finest=0.2, seed=seed)
        top = 0.5 + 0.012 * orange_peel(x, y, size=5.0, seed=seed + 6)
        return np.asarray(face(x, y) * top + (1 - face(x, y)) * sand)

    return Surface(
        recipe="tiled", relief=relief,
        colour=lambda x, y: mixed(
            np.array([0.5, 0.48, 0.44]) * np.ones((*np.shape(x), 1)),
            tinted(glaze, 0.05 * orange_peel(x, y, size=12.0, seed=seed + 3)), face(x, y)),
        gloss="coated", roughness=pick(rng, 0.03, 0.10), angle=angle,
    )  # fmt: skip


def carved(rng: np.random.Generator) -> Surface:
    """Return rings carved or pressed into clay and flooded with glaze that pools in them."""
    seed, glaze = stream(rng), _glaze(rng)
    centre = (pick(rng, -20, 20), pick(rng, -20, 20))
    pitch, rise = pick(rng, 3.5, 6.5), pick(rng, 0.10, 0.22)

    def waves(x: Array, y: Array) -> Array:
        return smoothstep(arcs(x, y, centre=centre, pitch=pitch), -0.6, 0.6)

    return Surface(
        recipe="carved",
        relief=lambda x, y: rise * waves(x, y) + 0.01 * orange_peel(x, y, size=4.0, seed=seed),
        colour=lambda x, y: tinted(glaze, 0.35 * (waves(x, y) - 0.8)),
        gloss="coated", roughness=pick(rng, 0.03, 0.1),
    )  # fmt: skip


RECIPES = {
    glazed: 2.0, crazed: 1.3, stoneware: 1.5, terracotta: 1.2, thrown: 0.8, tiled: 0.4, carved: 0.4,
}  # fmt: skip
