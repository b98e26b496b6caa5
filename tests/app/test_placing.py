"""Placing a pair on a map: exact where the map is linear."""

from dataclasses import replace

import numpy as np
import pytest

from app.placing import linear_map, on_map
from app.resources import Resources
from app.views import explore
from omnivat.errors import DataError

RANDOM = np.random.default_rng(0)


def unit(rows):
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def test_a_turned_linear_map_is_found_and_places_what_it_never_saw():
    rows, new = unit(RANDOM.normal(size=(60, 8))), unit(RANDOM.normal(size=(5, 8)))
    axes = np.linalg.qr(RANDOM.normal(size=(8, 8)))[0][:, :2]
    known = linear_map(rows, rows @ axes + 3)
    np.testing.assert_allclose(on_map(7 * new, rows, rows @ axes, known), new @ axes + 3, atol=1e-9)


def test_a_map_that_is_not_linear_is_not_taken_for_one():
    rows = unit(RANDOM.normal(size=(60, 8)))
    assert linear_map(rows, rows[:, :2] ** 2) is None


def test_without_a_linear_map_a_point_lands_among_its_neighbours():
    rows, flat = unit(RANDOM.normal(size=(60, 8))), RANDOM.normal(size=(60, 2))
    (place,) = on_map(rows[:1] + 1e-6, rows, flat, None)
    near = flat[np.argsort(-rows @ rows[0])[:15]]
    assert (near.min(0) <= place).all()
    assert (place <= near.max(0)).all()


@pytest.fixture
def with_frames(small_places, tmp_path):
    resources = Resources(replace(small_places, computed=tmp_path))
    assert resources.frames.wait().file, resources.frames.wait().problem
    return resources


def test_a_pair_of_the_set_is_placed_where_the_map_has_it(with_frames):
    from omnivat.frames import read_frames

    frames = read_frames(with_frames.frames.state().file)
    got = explore.place(
        with_frames,
        {
            "vis": "row:7",
            "tac": "row:7",
            "order": 0.5,
            "stage": "f_hat",
            "map": "pca",
            "nodes": True,
        },
    )
    drawn = frames.maps["pca/f_hat"]
    where = drawn.places(drawn.orders.index(frames.orders.index(got["order"])))
    assert got["exact"]
    np.testing.assert_allclose(got["points"]["vis"][0:2], where[7], atol=1e-3)
    np.testing.assert_allclose(got["points"]["tac"], where[7 + frames.pairs], atol=1e-3)
    assert len(got["nodes"]) == 7


def test_a_map_that_is_not_there_is_refused(with_frames):
    with pytest.raises(DataError, match="There is no map 'tsne/f_hat'"):
        explore.place(with_frames, {"vis": "row:1", "stage": "f_hat", "map": "tsne"})
