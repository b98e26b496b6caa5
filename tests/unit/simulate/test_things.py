"""A thing is one object; a look-alike looks like another class and keeps its touch."""

import numpy as np
import pytest

from omnivat.data.materials import MATERIALS
from omnivat.simulate.contact import plane
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.plan import planned
from omnivat.simulate.surfaces import surface
from omnivat.simulate.things import thing

X, Y = plane(20.0, 12)


def first(material, *, alike):
    pairs = planned(SIMULATED["OF Real"], material, pairs=60)
    return next(pair for pair in pairs if bool(pair.looks_like) == alike and not pair.feels_like)


@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("alike", [False, True])
def test_a_look_alike_looks_like_another_class_and_everything_else_is_what_it_is(material, alike):
    pair = first(material, alike=alike)
    made, own = thing(pair, seed=0), surface(material, pair.number, seed=0)
    plain = own.colour(X, Y)

    assert np.array_equal(made.sight.colour(X, Y), plain) != alike
    np.testing.assert_array_equal(made.touch.colour(X, Y), plain)
