"""A thing is one object; a look-alike looks like another class and keeps its touch."""

import numpy as np

from omnivat.data.materials import MATERIALS
from omnivat.simulate.contact import plane
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.plan import IMITATIONS, planned
from omnivat.simulate.surfaces import surface
from omnivat.simulate.things import thing


def first(material, *, alike):
    pairs = planned(SIMULATED["OF Real"], material, pairs=60)
    return next(pair for pair in pairs if bool(pair.looks_like) == alike and not pair.feels_like)


def test_an_honest_thing_shows_the_surface_of_its_class():
    pair = first("steel", alike=False)
    made, own = thing(pair, seed=0), surface("steel", pair.number, seed=0)
    x, y = plane(20.0, 12)

    np.testing.assert_array_equal(made.sight.colour(x, y), own.colour(x, y))
    assert made.touch.recipe == own.recipe


def test_a_look_alike_has_the_gloss_of_the_class_that_it_imitates_and_its_own_touch():
    for material in MATERIALS:
        pair = first(material, alike=True)
        made, own = thing(pair, seed=0), surface(material, pair.number, seed=0)

        assert made.looks_like == pair.looks_like != material
        assert made.touch.recipe == own.recipe
        assert made.sight.recipe != own.recipe


def test_the_same_pair_and_seed_give_the_same_thing():
    pair = first("glass", alike=False)
    once, again, other = thing(pair, seed=0), thing(pair, seed=0), thing(pair, seed=1)

    np.testing.assert_array_equal(once.solid.vertices, again.solid.vertices)
    np.testing.assert_array_equal(once.spot.point, again.spot.point)
    assert not np.array_equal(once.spot.point, other.spot.point)


def test_every_class_imitates_others_and_never_itself():
    assert tuple(IMITATIONS) == MATERIALS
    for material, looks in IMITATIONS.items():
        assert looks
        assert material not in looks
        assert set(looks) <= set(MATERIALS)
