"""Micro-relief: typical of its material, faint on smooth surfaces, absent on none."""

import numpy as np
import pytest

from omnivat.data.materials import MATERIALS
from omnivat.simulate.contact import plane
from omnivat.simulate.surfaces import RECIPES, SKINS, SMOOTH, skinned

X, Y = plane(16.0, 160)


def roughness(material):
    """Return the mean spread in mm of a material's skin."""
    return float(
        np.mean([SKINS[material](np.random.default_rng(s), 0.3)(X, Y).std() for s in range(4)])
    )


def test_every_material_has_a_skin_and_names_its_smooth_recipes():
    assert tuple(SKINS) == tuple(SMOOTH) == tuple(RECIPES) == MATERIALS
    assert all(maker in RECIPES[material] for material, maker in SMOOTH.items())


@pytest.mark.parametrize("material", ["wood", "steel", "plastic", "ceramic"])
def test_glass_is_smoother_than_every_other_material(material):
    assert roughness("glass") < 0.6 * roughness(material)


def test_wood_is_rough_across_its_grain_and_smooth_along_it():
    relief = SKINS["wood"](np.random.default_rng(1), 0.0)(X, Y)
    down, right = np.gradient(relief)

    assert down.std() > 2.5 * right.std()


@pytest.mark.parametrize("material", MATERIALS)
def test_a_smooth_recipe_keeps_less_of_the_skin_than_a_rough_one(material):
    added = {}
    for smooth in (True, False):
        maker = next(m for m in RECIPES[material] if (m is SMOOTH[material]) == smooth)
        own = maker(np.random.default_rng(2))
        skin = skinned(own, material, maker, np.random.default_rng(3))
        added[smooth] = (skin.relief(X, Y) - own.relief(X, Y)).std()

    assert 0.0 < added[True] < 0.8 * added[False]
