"""Placing a pair on a map: exact where the map is linear."""

import numpy as np
import pytest

from app.map_place import place
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
