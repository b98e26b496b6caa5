"""Dots printed on a gel are filled; every other picture comes back as it is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from omnivat.data.dots import fill_dots
from simulator.domains import SIMULATED
from simulator.drawing import tactile
from simulator.plan import planned
from simulator.things import thing
from tests.unit.data.odd_pictures import ODD, SIDE, gel, picture, printed


def with_dots(clean, shade):
    return picture(clean * (1 - shade[..., None]))


@settings(max_examples=20)
@given(
    pitch=st.floats(16, 38),
    share=st.floats(0.12, 0.17),
    turn=st.floats(-0.12, 0.12),
    darkness=st.floats(0.35, 0.95),
    square=st.booleans(),
    seed=st.integers(0, 99),
)
def test_a_printed_grid_is_found_and_filled_near_the_gel_below(
    pitch, share, turn, darkness, square, seed
):
    clean = gel(seed=seed)
    shade = printed(pitch=pitch, radius=share * pitch, turn=turn, darkness=darkness, square=square)
    filled, dots = fill_dots(with_dots(clean, shade))
    assert dots is not None and not dots.light
    assert np.abs(np.array(dots.pitch) - pitch).max() <= 1.5
    assert -0.5 <= dots.size - 2 * share * pitch <= 3
    below = shade > 0.1
    # grain alone: 4 × 2 / √π, and clipping
    assert np.abs(filled.astype(float) - clean)[below].mean() < 9


def test_dots_of_a_large_wide_picture_are_found_in_a_reduced_one():
    side = 500
    clean = gel(side)[:400]
    shade = printed(side, pitch=side / 9, radius=side / 60)[:400]
    filled, dots = fill_dots(with_dots(clean, shade))
    assert dots is not None and dots.number >= 55
    assert -0.5 <= dots.size - side / 30 <= 3
    assert np.abs(filled.astype(float) - clean)[shade > 0.1].mean() < 9


def test_light_dots_on_a_dark_gel_are_filled():
    clean = gel() / 3
    shade = printed()
    filled, dots = fill_dots(picture(clean + (235 - clean) * shade[..., None]))
    assert dots is not None and dots.light
    assert np.abs(filled.astype(float) - clean)[shade > 0.1].mean() < 9


def test_what_is_not_a_dot_keeps_its_bytes():
    marked = with_dots(gel(), shade := printed())
    filled, _ = fill_dots(marked)
    far = gaussian_filter((shade > 0).astype(float), 3) < 0.01
    assert far.any() and (filled[far] == marked[far]).all()
    assert filled is not marked and marked.flags.writeable  # the picture given stays


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("seed", range(3))
def test_a_picture_without_a_printed_grid_comes_back_as_it_is(name, seed):
    before = picture(ODD[name](SIDE, seed))
    copy = before.copy()
    after, dots = fill_dots(before)
    assert dots is None and after is before and (after == copy).all()


def test_a_picture_too_small_for_a_grid_comes_back_as_it_is():
    small = picture(gel(40))
    assert fill_dots(small) == (small, None)


def test_a_simulated_press_loses_its_dots_and_the_press_drawn_without_dots_stays():
    domain = SIMULATED["TQ-DuraGel"]
    made = thing(next(iter(planned(domain, "wood", pairs=8))), seed=0)
    sensor = replace(domain.sensor, plain_gels=0.0)
    bare = picture(255 * tactile(made, replace(sensor, markers=None), 5, size=SIDE))
    marked = picture(255 * tactile(made, sensor, 5, size=SIDE))
    assert fill_dots(bare)[0] is bare
    filled, dots = fill_dots(marked)
    change = np.abs(marked.astype(float) - bare).max(2)
    assert dots is not None
    assert (filled != marked).any(2)[change > 15].mean() > 0.95
    assert (
        np.abs(filled.astype(float) - bare)[change > 15].mean() < 0.25 * change[change > 15].mean()
    )
