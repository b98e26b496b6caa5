"""Micro-relief typical of a material, for all its recipes, in mm.

Wood has fibres and open pores, steel has tool marks and scratches, plastic has mould texture,
parting lines and sink marks, ceramic has wavy glaze with grit and pinholes. Glass is smooth: its
skin has only the long waves of fire polishing.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from omnivat.simulate.noise import Array, smoothstep, turned
from omnivat.simulate.surfaces import ceramic as ceramic_recipes
from omnivat.simulate.surfaces import glass as glass_recipes
from omnivat.simulate.surfaces import plastic as plastic_recipes
from omnivat.simulate.surfaces import steel as steel_recipes
from omnivat.simulate.surfaces import wood as wood_recipes
from omnivat.simulate.surfaces.base import (
    Field,
    Surface,
    arcs,
    grain,
    orange_peel,
    pick,
    pick_log,
    pits,
    ribs,
    scratches,
    streaks,
    stream,
)

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
    share = FAINT if maker in SMOOTH[material] else 1.0
    coarse = surface.relief

    def relief(x: Array, y: Array) -> Array:
        return np.asarray(coarse(x, y) + share * skin(x, y))

    return replace(surface, relief=relief)


def wood(rng: np.random.Generator, angle: float) -> Field:
    """Return fibres, and pores as short open slits along the grain."""
    seed, fibre, pore = stream(rng), pick_log(rng, 0.018, 0.035), pick_log(rng, 0.07, 0.13)
    width, length = pick(rng, 0.35, 0.6), pick(rng, 3.0, 6.0)
    level = pick(rng, 0.9, 1.3)

    def relief(x: Array, y: Array) -> Array:
        fibres = streaks(x, y, angle=angle, width=0.7, length=22.0, seed=seed)
        slits = streaks(x, y, angle=angle, width=width, length=length, seed=seed + 7)
        return fibre * fibres - pore * smoothstep(slits, level, level + 0.6)

    return relief


def steel(rng: np.random.Generator, angle: float) -> Field:
    """Return even tool marks, straight or about a far centre, and scratches across them."""
    seed, pitch = stream(rng), pick_log(rng, 0.45, 0.9)
    depth, count = pick_log(rng, 0.018, 0.032), int(rng.integers(15, 45))
    far = (150.0 * np.sin(angle), -150.0 * np.cos(angle))
    straight = bool(rng.random() < 0.6)

    def relief(x: Array, y: Array) -> Array:
        marks = 2.0 * ribs(x, y, angle=angle, pitch=pitch) - 1.0 if straight else arcs(x, y, centre=far, pitch=pitch)
        cuts = scratches(x, y, count=count, reach=40.0, width=0.12, seed=seed)
        return np.asarray(depth * marks - 0.05 * cuts)

    return relief


def plastic(rng: np.random.Generator, angle: float) -> Field:
    """Return even mould texture, sink marks, and the parting lines of the mould."""
    seed, texture = stream(rng), pick_log(rng, 0.020, 0.034)
    size, turn = pick(rng, 0.5, 0.9), pick(rng, 0, np.pi)
    apart, high = pick(rng, 9.0, 24.0), pick(rng, 0.07, 0.14)

    def relief(x: Array, y: Array) -> Array:
        even = grain(x, y, coarsest=size, finest=0.25, seed=seed)
        sunk = 0.02 * orange_peel(x, y, size=14.0, seed=seed + 5)
        across = turned(x, y, turn)[1]
        away = np.abs(across / apart - np.round(across / apart)) * apart
        line = 1.0 - smoothstep(away, 0.08, 0.28)
        return np.asarray(texture * even + sunk + high * line)

    return relief


def ceramic(rng: np.random.Generator, angle: float) -> Field:
    """Return a wavy glaze, grains of grit under it, and pinholes."""
    seed, wave = stream(rng), pick_log(rng, 0.03, 0.06)
    bump, holes = pick_log(rng, 0.07, 0.13), pick(rng, 0.15, 0.35)

    def relief(x: Array, y: Array) -> Array:
        waves = orange_peel(x, y, size=4.5, seed=seed)
        grit = pits(x, y, size=2.6, radius=0.55, share=0.35, seed=seed + 3)
        open_ = pits(x, y, size=2.2, radius=0.30, share=holes, seed=seed + 9)
        return np.asarray(wave * waves + bump * grit - 0.08 * open_)

    return relief


def glass(rng: np.random.Generator, angle: float) -> Field:
    """Return the long waves of fire-polished glass, which is otherwise smooth."""
    seed, rise = stream(rng), pick_log(rng, 0.004, 0.012)
    return lambda x, y: rise * orange_peel(x, y, size=11.0, seed=seed)


SKINS: dict[str, Callable[[np.random.Generator, float], Field]] = {
    "wood": wood,
    "steel": steel,
    "plastic": plastic,
    "ceramic": ceramic,
    "glass": glass,
}
