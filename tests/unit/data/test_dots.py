"""Dots printed on a gel are filled; every other picture comes back as it is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from omnivat.data.dots import fill_dots, filled
from omnivat.data.grid import between, common_steps, largest, reduced
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


@pytest.mark.parametrize("side", [337, 1080])
def test_dots_are_filled_at_every_size_of_a_picture(side):
    clean = gel(side)
    shade = printed(side, pitch=side / 9, radius=side / 60)
    filled, dots = fill_dots(with_dots(clean, shade))
    assert dots is not None and dots.number >= 70
    assert -0.5 <= dots.size - side / 30 <= 3
    assert np.abs(filled.astype(float) - clean)[shade > 0.1].mean() < 9


def test_a_wide_picture_is_filled_too():
    wide = np.concatenate([gel(), gel(seed=1)[:, :80]], 1)
    y, x = np.mgrid[:224, :304]
    shade = 0.8 * (np.hypot(x % 26 - 13, y % 26 - 13) < 4.5)
    assert (dots := fill_dots(with_dots(wide, shade))[1]) and dots.number >= 80


def test_missing_dots_and_a_press_leave_the_rest_of_the_grid_filled():
    clean = gel()
    shade = printed(missing=0.1, bulge=0.12)
    filled, dots = fill_dots(with_dots(clean, shade))
    assert dots is not None and dots.share < 1
    covered = (filled != with_dots(clean, shade)).any(2)
    assert covered[shade > 0.4].mean() > 0.97


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


def test_the_second_fill_finds_nothing():
    once, dots = fill_dots(with_dots(gel(), printed()))
    assert dots is not None
    again, none = fill_dots(once)
    assert none is None and again is once


@pytest.mark.parametrize("scale", [1, 2, 3, 16, 17])
def test_a_reduced_picture_has_the_exact_means_of_its_blocks(scale):
    shape = 5 * scale + scale // 2, 4 * scale
    values = np.random.default_rng(scale).integers(0, 256, shape, np.uint8)
    values[:scale] = 255  # the largest sum
    blocks = values[: 5 * scale].reshape(5, scale, 4, scale).astype(int)
    assert (reduced(values, scale) == blocks.sum((1, 3)) // scale**2).all()


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


@pytest.mark.parametrize("name", ["TAG", "OF Real", "TQ-DuraGel"])
def test_a_simulated_press_loses_its_dots_and_the_press_drawn_without_dots_stays(name):
    domain = SIMULATED[name]
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


def test_a_long_step_across_counts_as_much_as_one_down():
    """Of few points, a partner so far away lies inside the picture; the shorter step is first."""
    points = np.array([(x, y) for x in (20, 72, 124, 176) for y in (20, 74, 128, 182)])
    steps = np.abs(common_steps(points, (224, 224)))
    np.testing.assert_allclose(steps, [[52, 0], [0, 54]], atol=1)


def test_the_largest_group_of_linked_points_is_kept():
    """Points 1, 0 and 2 in a row, and 3 and 4."""
    links = np.array([[2, 0, -1, 4, -1], [1, -1, 0, -1, 3]])
    assert largest(links, np.ones(5, bool)).tolist() == [True, True, True, False, False]


def test_the_gel_between_nodes_is_looked_at_halfway():
    dark = np.zeros((40, 40), np.uint8)
    dark[19:22, 9:12] = dark[9:12, 19:22] = dark[19:22, 19:22] = 90
    assert between(dark, np.array([[10, 10]]), np.array([[20, 0], [0, 20]])) == 90


def test_a_hole_takes_the_grain_half_a_cell_away_that_lies_inside_the_picture():
    """The places of the first two lie on the rim of the picture, or beyond it."""
    flat, hole = np.full((40, 40, 3), 100, np.uint8), np.zeros((40, 40), bool)
    for row, column, right, down in (
        (36, 4, 4, -3),
        (20, 35, -4, -3),
        (3, 35, -4, 3),
        (20, 20, 4, 3),
    ):
        hole[row, column] = True
        flat[row + down, column + right] = 190
    assert (filled(flat, hole, np.array([[8, 0], [0, 6]]))[hole] == 180).all()
