"""Placing a pair on a map: exact where the map is linear."""

import numpy as np
import pytest
import torch

from app.map_place import journey, place
from app.resources import Resources
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES


@pytest.fixture
def with_frames(framed):
    return Resources(framed)


@pytest.mark.parametrize("kind", ["pca", "umap"])
@pytest.mark.parametrize(("ref", "row"), [("row:7", 7), ("example:TAG-sim/wood/0", 0)])
def test_a_pair_of_the_set_is_placed_where_the_map_has_it(with_frames, ref, row, kind):
    from omnivat.maps.frames import read_frames

    frames = read_frames(with_frames.frames.state().file)
    asked = {"vis": ref, "tac": ref, "order": 0.5, "map": kind}
    got = place(with_frames, asked)
    drawn = frames.maps[f"{kind}/f_hat"]
    where = drawn.places(drawn.orders.index(frames.orders.index(got["order"])))
    assert got["exact"]
    assert got["points"] == {"vis": where[row].tolist(), "tac": where[row + frames.pairs].tolist()}


def test_a_picture_with_the_vector_of_a_pair_is_placed_where_the_pair_is(with_frames):
    with_frames._sent.keep("sent", dict.fromkeys(IMAGES, with_frames.embeddings().vis[7]))
    asked = {"tac": "row:7", "order": 0.5, "map": "pca"}
    there, sent = (place(with_frames, {"vis": ref, **asked}) for ref in ("row:7", "image:sent"))
    assert there["exact"] and sent["exact"]
    np.testing.assert_allclose(sent["points"]["vis"], there["points"]["vis"], atol=1e-3)


def test_a_pair_is_placed_at_the_stop_nearest_to_its_order_and_the_learned_one_by_default(
    with_frames,
):
    asked = {"vis": "row:7", "map": "umap"}
    orders = [place(with_frames, {**asked, "order": order})["order"] for order in (0.0, 0.56, 1.0)]
    assert orders == pytest.approx([0.0, 0.55, 1.0], abs=0.011)
    learned = with_frames.head().model.order
    found = place(with_frames, {**asked, "map": "pca"})
    assert found["order"] == learned and set(found["points"]) == {"vis"}


def test_a_map_that_is_not_there_is_refused(with_frames):
    with pytest.raises(DataError, match="There is no map 'tsne'"):
        place(with_frames, {"vis": "row:1", "map": "tsne"})


def test_a_pair_is_sent_with_its_place_tree_and_readings_at_every_stop(with_frames):
    from omnivat.maps.frames import read_frames

    frames = read_frames(with_frames.frames.state().file)
    got = journey(with_frames, {"vis": "row:7", "tac": "row:7"})
    drawn = frames.maps["umap/f_hat"]
    own = [drawn.places(drawn.orders.index(stop))[7] for stop in got["stops"]]
    np.testing.assert_allclose(got["maps"]["umap"]["places"]["vis"], own, atol=1e-5)
    assert got["orders"] == tuple(frames.orders[stop] for stop in got["stops"])
    assert got["maps"]["pca"]["exact"] and not got["maps"]["umap"]["exact"]
    assert np.shape(got["maps"]["pca"]["nodes"]) == (21, 7, 2)
    assert np.shape(got["tree"]["probabilities"]) == (21, 7, 5)
    assert got["tree"]["parents"] == [-1, 0, 0, 1, 1, 2, 2] and got["own"] is None
    row = torch.from_numpy(with_frames.embeddings().vis[7:8].copy())
    alone = journey(with_frames, {"vis": "row:7"})
    for at in (0, 10, 20):
        wanted = with_frames.head().model(row, None, order=got["orders"][at]).probabilities
        np.testing.assert_allclose(alone["readings"]["fused"][at], wanted[0], atol=1e-5)


def test_the_features_of_the_set_are_computed_once_for_all_journeys(with_frames, monkeypatch):
    from omnivat.maps import journey as module

    walks = []
    walk = module.walk
    monkeypatch.setattr(module, "walk", lambda *a, **o: walks.append(1) or walk(*a, **o))
    for row in (1, 2, 3):
        journey(with_frames, {"tac": f"row:{row}"})
    assert len(walks) == 1
    monkeypatch.setattr("app.map_place.KEPT_STOPS", 0)  # a large set keeps none
    large = Resources(with_frames.where)
    for row in (1, 2):
        journey(large, {"tac": f"row:{row}"})
    assert len(walks) == 3
