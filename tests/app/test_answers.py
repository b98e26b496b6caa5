"""Smaller results: attention, a camera's picture, a record without targets."""

import base64

import numpy as np
import pytest

from app.pair import tab as pair
from app.pair.pictures import live
from app.serving import about
from app.shared.requests import FILES


def test_attention_adds_up_to_one_for_each_token_that_asks(resources):
    got = pair.attention(resources, {"vis": "row:1", "tac": "row:1"})
    count = got["count"]["vis"]
    off = {
        name: np.frombuffer(base64.b64decode(text), np.int8) for name, text in got["off"].items()
    }
    assert max(np.abs(one).max() for one in off.values()) == 127
    sums = off["vis"].reshape(101, count, count).sum(-1) / 127 * got["scale"]
    assert np.abs(sums).max() < count / 127 * got["scale"]


def test_a_cameras_picture_is_answered_and_not_kept(resources, encoder, png):
    for _ in range(2):
        found = live(resources, {"modality": "vis", FILES: [png()]})
    assert encoder.calls == 2
    assert set(found["readings"]) == {"fused", "vis"}
    assert sum(found["readings"]["fused"]) == pytest.approx(1, abs=1e-3)


def test_a_record_without_any_target_can_be_sent():
    sent = about.without_nan({"target_accuracy": float("nan"), "seeds": [{"order": 0.5}]})
    assert sent == {"target_accuracy": None, "seeds": [{"order": 0.5}]}


def test_two_live_pictures_are_predicted_as_the_pair_of_them(resources, png):
    photo, touch = png(seed=1), png(seed=2)
    refs = (str(resources.take_image(content, "a.png")[0]) for content in (photo, touch))
    found = live(resources, {"modality": "both", FILES: [photo, touch]})
    pair_of_both = pair.predicted(resources, dict(zip(("vis", "tac"), refs, strict=True)))
    assert found["readings"].keys() == pair_of_both["exact"]["readings"].keys()
    for name, row in pair_of_both["exact"]["readings"].items():
        assert found["readings"][name] == pytest.approx(row, abs=2e-6)
    assert found["images"] == pair_of_both["images"]
