"""Presses: spots in the middle of the gel, and surfaces of the class that a thing feels like."""

import numpy as np
import pytest

from omnivat.simulate.contact import plane
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.plan import planned
from omnivat.simulate.shapes import KINDS, made_of
from omnivat.simulate.shapes.spots import contact_height
from omnivat.simulate.surfaces import SMOOTH
from omnivat.simulate.things import touch_surface, touched_spot

STEEL = planned(SIMULATED["TAG"], "steel", pairs=60)


@pytest.mark.parametrize("name", ["mug", "fork", "bench", "candlestick", "panel"])
def test_a_sensor_meets_the_object_first_in_the_middle_of_its_gel(name):
    beside = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        solid = KINDS[name](rng, made_of("wood", rng))
        height = contact_height(solid, touched_spot(solid, rng), field=14.0, size=36)
        x, y = plane(14.0, 36)
        beside += height.max() > height[np.hypot(x, y) < 3.5].max() + 0.1

    assert beside <= 1


def test_a_thing_feels_like_the_class_that_it_imitates_by_touch_whatever_it_looks_like():
    alike = [pair for pair in STEEL if pair.feels_like]
    looks = [pair for pair in STEEL if pair.looks_like]

    assert alike and looks
    for pair in alike:
        smooth = SMOOTH[pair.feels_like](np.random.default_rng(0))
        assert touch_surface(pair, seed=0).gloss == smooth.gloss != "metal"
    assert {touch_surface(pair, seed=0).gloss for pair in looks} == {"metal"}
