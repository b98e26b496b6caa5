"""Presses: spots in the middle of the gel, and surfaces of the class that a thing feels like."""

import numpy as np

from simulator.domains import SIMULATED
from simulator.plan import planned
from simulator.surfaces import SMOOTH
from simulator.things import touch_surface

STEEL = planned(SIMULATED["TAG"], "steel", pairs=60)


def test_a_thing_feels_like_the_class_that_it_imitates_by_touch_whatever_it_looks_like():
    alike = [pair for pair in STEEL if pair.feels_like]
    looks = [pair for pair in STEEL if pair.looks_like]

    assert alike and looks
    for pair in alike:
        smooth = SMOOTH[pair.feels_like](np.random.default_rng(0))
        assert touch_surface(pair, seed=0).gloss == smooth.gloss != "metal"
    assert {touch_surface(pair, seed=0).gloss for pair in looks} == {"metal"}
