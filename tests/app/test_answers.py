"""Smaller results: attention, a camera's picture, a measurement, retrained heads."""

import base64

import numpy as np
import pytest

from app.measuring import measured
from app.pictures import Sent, live
from app.state import Ref
from app.views import data, pair, tree
from omnivat.kit.errors import DataError


def test_attention_adds_up_to_one_for_each_token_that_asks(resources):
    got = pair.attention(resources, {"vis": "row:1", "tac": "row:1"})
    count = got["count"]["vis"]
    off = np.frombuffer(base64.b64decode(got["off"]["vis"]), dtype=np.int8)
    sums = off.reshape(101, count, count).sum(-1) / 127 * got["scale"]
    assert np.abs(sums).max() < count / 127 * got["scale"]
    assert len(got["tokens"]["vis"]) == count
    assert got["tokens"]["vis"][0].startswith("Re × ")


def test_a_cameras_picture_is_answered_and_not_kept(resources, encoder, png):
    content = png()
    first = live(resources, Sent(content=content, modality="vis", other=Ref("row", "3"), order=0.5))
    live(resources, Sent(content=content, modality="vis", other=Ref("row", "3"), order=0.5))
    assert encoder.calls == 2
    assert set(first["readings"]) == {"fused", "vis", "tac", "vis_branch", "tac_branch"}
    assert sum(first["readings"]["fused"]) == pytest.approx(1, abs=1e-3)


def test_a_picture_of_another_modality_is_refused(resources, png):
    with pytest.raises(DataError, match="it is vis, tac or both"):
        live(resources, Sent(content=png(), modality="smell"))


def test_a_measurement_names_its_error_and_its_spread(resources):
    got = measured(resources, {})
    assert len(got["rows"]) == 5
    for row in got["rows"]:
        assert row["ms"]["least"] <= row["ms"]["median"] <= row["ms"]["most"]
        assert 0 <= row["error"] < 1e-4
        assert row["of"]


def test_a_domains_tree_is_the_mean_of_its_pairs_trees(resources):
    rows = np.flatnonzero(resources.embeddings().domain == 1)
    whole = tree.tree(resources, {"domain": "OF Real-sim", "order": 0.5})
    each = [tree.tree(resources, {"vis": f"row:{r}", "tac": f"row:{r}", "order": 0.5}) for r in rows]
    assert whole["pairs"] == len(rows)
    norms = np.mean([[node["norm"] for node in one["nodes"]] for one in each], axis=0)
    np.testing.assert_allclose([node["norm"] for node in whole["nodes"]], norms, atol=1e-3)
    cosines = np.mean([one["layers"][2]["cosines"] for one in each], axis=0)
    np.testing.assert_allclose(whole["layers"][2]["cosines"], cosines, atol=1e-4)
    assert all(0 <= node["right"] <= 1 for node in whole["nodes"])


def test_a_domain_that_is_not_there_is_refused(resources):
    with pytest.raises(DataError, match="No domain is called 'Mars'"):
        tree.tree(resources, {"domain": "Mars"})


def test_a_record_without_any_target_can_be_sent():
    sent = data.without_nan({"target_accuracy": float("nan"), "seeds": [{"order": 0.5}]})
    assert sent == {"target_accuracy": None, "seeds": [{"order": 0.5}]}


def test_two_live_pictures_are_predicted_as_each_with_the_other_sent_before(resources, png):
    photo, touch = png(seed=1), png(seed=2)
    ref, _ = resources.take_image(touch, "touch.png")
    both = live(resources, Sent(content=photo + touch, modality="both", split=len(photo)))
    one = live(resources, Sent(content=photo, modality="vis", other=ref))
    assert both["readings"] == one["readings"]
    assert set(both["images"]) == set(one["images"])


@pytest.mark.parametrize("split", [0, 10**8])
def test_two_live_pictures_need_the_place_where_the_second_begins(resources, png, split):
    with pytest.raises(DataError, match="split is"):
        live(resources, Sent(content=png(), modality="both", split=split))
