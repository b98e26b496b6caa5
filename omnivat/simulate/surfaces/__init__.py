"""Procedural surfaces of the five materials: many distinct objects of each, from a seed.

A recipe is a function from a random generator to a `Surface`. Recipes of different materials are
similar on purpose (ribbed glass and ribbed plastic, cast steel and moulded plastic), so that
neither sight nor touch alone is always enough.
"""

from collections.abc import Callable

import numpy as np

from omnivat.seeding import derive_seed
from omnivat.simulate.surfaces import ceramic, glass, plastic, steel, wood
from omnivat.simulate.surfaces.base import Surface

__all__ = ["RECIPES", "Surface", "recipe", "surface"]

Recipe = Callable[[np.random.Generator], Surface]

RECIPES = {
    "wood": wood.RECIPES,
    "steel": steel.RECIPES,
    "plastic": plastic.RECIPES,
    "ceramic": ceramic.RECIPES,
    "glass": glass.RECIPES,
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
