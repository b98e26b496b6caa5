"""Smaller results: attention, a camera's picture, a record without targets."""

import base64

import numpy as np
import pytest

from app import about
from app.pictures import live
from app.views import pair


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
    content = png()
    question = {"modality": "vis", "other": "row:3", "order": 0.5}
    first = live(resources, content, question)
    live(resources, content, question)
    assert encoder.calls == 2
    assert set(first["readings"]) == {"fused", "vis", "tac", "vis_branch", "tac_branch"}
    assert sum(first["readings"]["fused"]) == pytest.approx(1, abs=1e-3)


def test_a_record_without_any_target_can_be_sent():
    sent = about.without_nan({"target_accuracy": float("nan"), "seeds": [{"order": 0.5}]})
    assert sent == {"target_accuracy": None, "seeds": [{"order": 0.5}]}


def test_two_live_pictures_are_predicted_as_each_with_the_other_sent_before(resources, png):
    photo, touch = png(seed=1), png(seed=2)
    ref, _ = resources.take_image(touch, "touch.png")
    both = live(resources, photo + touch, {"modality": "both", "split": len(photo)})
    one = live(resources, photo, {"modality": "vis", "other": str(ref)})
    assert both["readings"] == one["readings"]
    assert set(both["images"]) == set(one["images"])
