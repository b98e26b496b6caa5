"""Micro-relief typical of a material, for all its recipes, in mm.

Wood has fibres and open pores, steel has tool marks and scratches, plastic has mould texture,
parting lines and sink marks, ceramic has wavy glaze with grit and pinholes. Glass is smooth: its
skin has only the long waves of fire polishing.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from omnivat.simulate.fields import Field, arcs, field, grain, orange_peel, pits, ribs, scratches, smooth, streaks
from omnivat.simulate.noise import Array, smoothstep, turned
from omnivat.simulate.surfaces import ceramic as ceramic_recipes
from omnivat.simulate.surfaces import glass as glass_recipes
from omnivat.simulate.surfaces import plastic as plastic_recipes
from omnivat.simulate.surfaces import steel as steel_recipes
from omnivat.simulate.surfaces import wood as wood_recipes
from omnivat.simulate.surfaces.base import Surface, pick, pick_log, stream

FAINT = 0.7  # share of the skin left on a smooth or coated surface
Maker = Callable[[np.random.Generator], Surface]
SMOOTH: dict[str, tuple[Maker, ...]] = {
    "wood": (wood_recipes.varnished,),
    "steel": (steel_recipes.ground,),
    "plastic": (plastic_recipes.glossy,),
    "ceramic": (ceramic_recipes.glazed,),
    "glass": (glass_recipes.float_glass,),
}


def spend(material: str, rng: np.random.Generator) -> None:
    """Draw what a curvature once took, so that the shipped objects keep their bytes."""
    drawn = rng.random() if material != "glass" else 0.0
    if drawn >= {"steel": 0.72, "plastic": 0.45, "ceramic": 0.12}.get(material, 1.0):
        rng.random(3 if material == "ceramic" and drawn >= 0.35 else 2)


def skinned(surface: Surface, material: str, maker: Maker, rng: np.random.Generator) -> Surface:
    """Return a surface with its material's own micro-relief, in line with its grain.

    maker  the recipe that made the surface: smooth ones keep a faint skin only
    """
    skin = SKINS[material](rng, surface.angle)
    return replace(surface, relief=surface.relief + (FAINT if maker in SMOOTH[material] else 1.0) * skin)


def wood(rng: np.random.Generator, angle: float) -> Field:
    """Return fibres, and pores as short open slits along the grain."""
    seed, fibre, pore = stream(rng), pick_log(rng, 0.018, 0.035), pick_log(rng, 0.07, 0.13)
    width, length, level = pick(rng, 0.35, 0.6), pick(rng, 3.0, 6.0), pick(rng, 0.9, 1.3)
    fibres = streaks(angle=angle, width=0.7, length=22.0, seed=seed)
    slits = streaks(angle=angle, width=width, length=length, seed=seed + 7)
    return fibre * fibres - pore * smooth(slits, level, level + 0.6)


def steel(rng: np.random.Generator, angle: float) -> Field:
    """Return even tool marks, straight or about a far centre, and scratches across them."""
    seed, pitch = stream(rng), pick_log(rng, 0.45, 0.9)
    depth, count = pick_log(rng, 0.018, 0.032), int(rng.integers(15, 45))
    far = (150.0 * np.sin(angle), -150.0 * np.cos(angle))
    straight = rng.random() < 0.6
    marks = 2.0 * ribs(angle=angle, pitch=pitch) - 1.0 if straight else arcs(centre=far, pitch=pitch)
    return depth * marks - 0.05 * scratches(count=count, reach=40.0, width=0.12, seed=seed)


def plastic(rng: np.random.Generator, angle: float) -> Field:
    """Return even mould texture, sink marks, and the parting lines of the mould."""
    seed, texture = stream(rng), pick_log(rng, 0.020, 0.034)
    size, turn = pick(rng, 0.5, 0.9), pick(rng, 0, np.pi)
    apart, high = pick(rng, 9.0, 24.0), pick(rng, 0.07, 0.14)

    @field
    def parting(x: Array, y: Array) -> Array:
        across = turned(x, y, turn)[1]
        return 1.0 - smoothstep(np.abs(across / apart - np.round(across / apart)) * apart, 0.08, 0.28)

    sunk = 0.02 * orange_peel(size=14.0, seed=seed + 5)
    return texture * grain(coarsest=size, finest=0.25, seed=seed) + sunk + high * parting()


def ceramic(rng: np.random.Generator, angle: float) -> Field:
    """Return a wavy glaze, grains of grit under it, and pinholes."""
    seed, wave = stream(rng), pick_log(rng, 0.03, 0.06)
    bump, holes = pick_log(rng, 0.07, 0.13), pick(rng, 0.15, 0.35)
    grit = pits(size=2.6, radius=0.55, share=0.35, seed=seed + 3)
    open_ = pits(size=2.2, radius=0.30, share=holes, seed=seed + 9)
    return wave * orange_peel(size=4.5, seed=seed) + bump * grit - 0.08 * open_


def glass(rng: np.random.Generator, angle: float) -> Field:
    """Return the long waves of fire-polished glass, which is otherwise smooth."""
    seed, rise = stream(rng), pick_log(rng, 0.004, 0.012)
    return rise * orange_peel(size=11.0, seed=seed)


SKINS: dict[str, Callable[[np.random.Generator, float], Field]] = {
    "wood": wood,
    "steel": steel,
    "plastic": plastic,
    "ceramic": ceramic,
    "glass": glass,
}
