"""Surfaces: functions of place, the same for the same seed, different for different numbers."""

import numpy as np
import pytest

from omnivat.simulate.contact import plane
from omnivat.simulate.surfaces import RECIPES, recipe, surface

EVERY_RECIPE = [
    pytest.param(maker, id=f"{material}-{maker.__name__}")
    for material, makers in RECIPES.items()
    for maker in makers
]


@pytest.mark.parametrize("maker", EVERY_RECIPE)
def test_every_recipe_gives_finite_relief_of_a_tangible_size_and_colours_in_range(maker):
    x, y = plane(16.0, 48)
    thing = maker(np.random.default_rng(5))
    relief, colour = thing.relief(x, y), thing.colour(x, y)

    assert relief.shape == x.shape
    assert np.isfinite(relief).all()
    assert np.ptp(relief) < 2.0  # mm: a relief, not a shape
    assert colour.shape == (*x.shape, 3)
    assert colour.min() >= 0.0
    assert colour.max() <= 1.0


def test_the_same_number_is_the_same_object_and_another_number_another():
    x, y = plane(10.0, 24)
    once, again = (surface("steel", 7, seed=0).relief(x, y) for _ in range(2))
    other = surface("steel", 8, seed=0).relief(x, y)
    reseeded = surface("steel", 7, seed=1).relief(x, y)

    np.testing.assert_array_equal(once, again)
    assert not np.array_equal(once, other)
    assert not np.array_equal(once, reseeded)


def test_a_surface_has_one_height_at_one_place_whoever_looks():
    thing = surface("wood", 3, seed=0)
    x, y = plane(20.0, 40)
    part = (slice(5, 12), slice(20, 31))

    np.testing.assert_allclose(thing.relief(x[part], y[part]), thing.relief(x, y)[part], atol=1e-12)


def test_neighbouring_numbers_hold_a_mixture_of_recipes():
    for material, recipes in RECIPES.items():
        seen = {recipe(material, number, seed=0) for number in range(40)}
        assert len(seen) >= len(recipes) - 2, material
