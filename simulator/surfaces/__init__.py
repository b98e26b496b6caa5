"""Procedural surfaces of the five materials: many distinct objects of each, from a seed.

A recipe is a function from a random generator to a `Surface`. Recipes of different materials are
similar on purpose (ribbed glass and ribbed plastic, cast steel and moulded plastic), so that
neither sight nor touch alone is always enough.

Each material also has a skin, a micro-relief of all its recipes: wood has fibres and open pores,
steel has tool marks and scratches, plastic has mould texture, parting lines and sink marks, ceramic
has wavy glaze with grit and pinholes. Glass is smooth: its skin has only the long waves of fire
polishing.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from omnivat.kit.seeding import derive_seed
from simulator.fields import Field
from simulator.noise import Rng
from simulator.surfaces import ceramic, glass, plastic, steel, wood
from simulator.surfaces.base import Surface

__all__ = ["RECIPES", "SKINS", "SMOOTH", "Surface", "recipe", "skinned", "spend", "surface"]

Recipe = Callable[[Rng], Surface]

FAINT = 0.7  # share of the skin left on a smooth or coated surface
_MATERIALS = {"wood": wood, "steel": steel, "plastic": plastic, "ceramic": ceramic, "glass": glass}
RECIPES: dict[str, dict[Recipe, float]] = {name: room.RECIPES for name, room in _MATERIALS.items()}
SMOOTH: dict[str, Recipe] = {name: room.SMOOTH for name, room in _MATERIALS.items()}
SKINS: dict[str, Callable[[Rng, float], Field]] = {
    name: room.skin for name, room in _MATERIALS.items()
}


def surface(material: str, number: int, *, seed: int) -> Surface:
    """Return object `number` of a material; the same seed and number give the same object."""
    make = recipe(material, number, seed=seed)
    return make(np.random.default_rng(derive_seed(seed, "surface", material, number)))


def recipe(material: str, number: int, *, seed: int) -> Recipe:
    """Return the recipe of that object.

    Recipes follow a fixed rotation by weight, so that consecutive numbers have a balanced mixture.
    """
    recipes = RECIPES[material]
    weights = np.cumsum(list(recipes.values()))
    golden = (number * 0.6180339887 + (derive_seed(seed, "rotation", material) % 997) / 997) % 1.0
    return list(recipes)[int(np.searchsorted(weights, golden * weights[-1]))]


def spend(material: str, rng: Rng) -> None:
    """Draw what a curvature once took, so that the shipped objects keep their bytes."""
    drawn = rng.random() if material != "glass" else 0.0
    if drawn >= {"steel": 0.72, "plastic": 0.45, "ceramic": 0.12}.get(material, 1.0):
        rng.random(3 if material == "ceramic" and drawn >= 0.35 else 2)


def skinned(surface: Surface, material: str, maker: Recipe, rng: Rng) -> Surface:
    """Return a surface with its material's own micro-relief, in line with its grain.

    maker  the recipe that made the surface: smooth ones keep a faint skin only
    """
    skin = SKINS[material](rng, surface.angle)
    return replace(
        surface, relief=surface.relief + (FAINT if maker is SMOOTH[material] else 1.0) * skin
    )
