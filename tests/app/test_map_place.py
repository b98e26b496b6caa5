"""A pair at every stop of p on the maps of the set."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from app.shared.map_place import journey
from app.shared.resources import Resources
from omnivat.kit.errors import DataError
from omnivat.maps.frames import read_frames


@pytest.fixture
def with_frames(framed):
    return Resources(framed)


def test_heads_beside_the_first_have_their_own_maps_and_a_mode_needs_its_weights(framed, tmp_path):
    folder = tmp_path / "set"
    folder.mkdir()
    for file in (framed.embeddings, framed.embeddings.with_suffix(".csv")):
        (folder / file.name).write_bytes(file.read_bytes())
    (folder / "every.bin").write_bytes(framed.frames.read_bytes())
    where = replace(framed, embeddings=folder / framed.embeddings.name, compare=(framed.head,))
    resources = Resources(where)
    asked = {"vis": "row:7", "tac": "row:7"}
    first = journey(resources, asked)
    name = framed.head.parent.name
    resources.frame_jobs[name]._file = framed.frames
    assert journey(resources, {**asked, "head": name}) == first
    with pytest.raises(DataError, match="weights behind these frames are not here"):
        journey(resources, {**asked, "mode": "every"})
    (folder / "every").symlink_to(framed.head)
    assert journey(resources, {**asked, "mode": "every"}) == first
    with pytest.raises(DataError, match="mode is 'moved'"):
        journey(resources, {**asked, "mode": "moved"})


def test_a_pair_is_sent_with_its_place_tree_and_readings_at_every_stop(with_frames):
    frames = read_frames(with_frames.where.frames)
    got = journey(with_frames, {"vis": "row:7", "tac": "row:7"})
    drawn = frames.maps["umap/f_hat"]
    own = [drawn.places(drawn.orders.index(stop))[7] for stop in got["stops"]]
    np.testing.assert_allclose(got["maps"]["umap"]["places"]["vis"], own, atol=1e-4)
    assert got["orders"] == tuple(frames.orders[stop] for stop in got["stops"])
    assert got["maps"]["pca"]["exact"] and not got["maps"]["umap"]["exact"]
    assert np.shape(got["maps"]["pca"]["nodes"]) == (4, 7, 2)
    assert np.shape(got["tree"]["probabilities"]) == (4, 7, 5)
    assert got["tree"]["parents"] == [-1, 0, 0, 1, 1, 2, 2] and got["own"] is None
    row = torch.from_numpy(with_frames.embeddings().vis[7:8].copy())
    alone = journey(with_frames, {"vis": "row:7"})
    for at in (0, 2, 3):
        wanted = with_frames.head().model(row, None, order=got["orders"][at]).probabilities
        np.testing.assert_allclose(alone["readings"]["fused"][at], wanted[0], atol=1e-4)


def test_the_features_of_the_set_are_computed_once_for_all_journeys(with_frames, monkeypatch):
    from omnivat.maps import journey as module

    walks = []
    walk = module.walk
    monkeypatch.setattr(module, "walk", lambda *a, **o: walks.append(1) or walk(*a, **o))
    for row in (1, 2, 3):
        journey(with_frames, {"tac": f"row:{row}"})
    assert len(walks) == 1
    monkeypatch.setattr("app.shared.map_place.KEPT_STOPS", 0)  # a large set keeps none
    large = Resources(with_frames.where)
    for row in (1, 2):
        journey(large, {"tac": f"row:{row}"})
    assert len(walks) == 3
