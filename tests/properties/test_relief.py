"""Laws of a gel's lamps and of heights: what turns, mirrors, swaps and scales with the picture."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array, vstack
from scipy.sparse.linalg import lsqr

from omnivat.data.relief import lamps, slopes
from omnivat.data.relief.surface import integrated
from tests.unit.data.reliefs import cosine, pressed, shown, touches

few = settings(max_examples=8, deadline=None)
seeds = st.integers(0, 2**20)
FOUND = lamps(touches(3, 6), dots="keep")


@few
@given(seeds, st.integers(5, 9), st.lists(st.floats(-30, 30), min_size=6, max_size=6))
def test_lamps_are_recovered_from_random_reliefs(seed, count, entries):
    lit = np.array(entries).reshape(3, 2)
    strong, weak = np.linalg.svd(lit, compute_uv=False)
    assume(strong > 15 and weak > 0.35 * strong)
    found = lamps(touches(seed, count, lit), dots="keep")
    assert cosine(found.colours, lit) > 0.97
    assert found.ratio < 0.4 and found.confidence > 0.9 and found.pictures == count


@pytest.mark.parametrize(
    ("change", "turned"),
    [
        (lambda p: np.rot90(p), lambda m: np.stack([m[:, 1], -m[:, 0]], 1)),
        (lambda p: p[:, ::-1], lambda m: m * [-1, 1]),
        (lambda p: p[..., ::-1], lambda m: m[::-1]),
        (lambda p: 255 - p, lambda m: -m),
        (lambda p: 64 + p // 2, lambda m: m / 2),
    ],
    ids=["turned", "mirrored", "swapped", "negative", "fainter"],
)
def test_lamps_turn_mirror_swap_and_fade_with_the_picture(change, turned):
    """The negative alone changes what is hollow: its relief is the opposite, its lamps the same."""
    found = lamps([change(p) for p in touches(3, 6)], dots="keep").colours
    expected = turned(FOUND.colours)
    if change(np.zeros((2, 2, 3), np.uint8)).max() == 255:
        expected = np.abs(cosine(found, expected)) * found
    assert np.abs(found - expected).max() < 0.02 * np.abs(FOUND.colours).max()


@few
@given(seeds)
def test_slopes_are_those_of_the_relief(seed):
    sheet = pressed(np.random.default_rng(seed))
    down, right = np.gradient(sheet)
    found = slopes(shown(sheet), FOUND, dots="keep")
    for k, true in enumerate((right, down)):
        assert np.corrcoef(found[..., k].ravel(), true.ravel())[0, 1] > 0.85


def differences(height, width):
    """The matrix of differences between neighbours: to the right, then downwards."""
    place = np.arange(height * width).reshape(height, width)
    parts = []
    for first, second in ((place[:, :-1], place[:, 1:]), (place[:-1], place[1:])):
        row = np.arange(first.size)
        ends = np.concatenate([row, row]), np.concatenate([second.ravel(), first.ravel()])
        parts.append(
            coo_array((np.repeat([1.0, -1.0], first.size), ends), (first.size, place.size))
        )
    return vstack(parts).tocsr()


@few
@given(seeds, st.integers(3, 12), st.integers(3, 12))
def test_heights_are_the_least_squares_of_any_slopes(seed, height, width):
    field = np.random.default_rng(seed).normal(size=(height, width, 2))
    right, down = field[..., 0], field[..., 1]
    wanted = [(right[:, 1:] + right[:, :-1]) / 2, (down[1:] + down[:-1]) / 2]
    wanted = np.concatenate([one.ravel() for one in wanted])
    best = lsqr(differences(height, width), wanted, atol=1e-13, btol=1e-13)[0]
    assert np.abs(integrated(field).ravel() - (best - best.mean())).max() < 1e-6
