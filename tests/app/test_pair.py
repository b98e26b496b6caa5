"""The Pair tab's predictions, without Gradio and without a server."""

import base64
from dataclasses import replace

import numpy as np
import pytest
import torch

from app.pair.tab import many, predicted, rivals, spectrum, trained_span
from app.shared.resources import Resources
from app.shared.state import ForgottenError
from omnivat.data.store import save_embeddings
from omnivat.kit.stages import IMAGES


@pytest.mark.parametrize("images", [("vis", "tac"), ("tac",)])
def test_every_stop_is_what_the_library_answers_there(resources, images):
    got = predicted(resources, dict.fromkeys(images, "row:3"))
    model, embeddings = resources.head().model, resources.embeddings()
    pair = [
        torch.tensor(getattr(embeddings, name)[3:4]) if name in images else None for name in IMAGES
    ]
    with torch.inference_mode():
        exact = model(*pair).readings
        for stop in (0, 37, 100):
            readings = model(*pair, order=stop / 100).readings
            for name, rows in got["stops"].items():
                np.testing.assert_allclose(rows[stop], readings[name][0], atol=2e-6)
    assert got["exact"]["order"] == got["learned"] == model.order
    assert got["exact"]["readings"].keys() == exact.keys()
    for name, row in got["exact"]["readings"].items():
        np.testing.assert_allclose(row, exact[name][0], atol=2e-6)


def test_a_set_that_stays_in_its_file_gives_the_same_readings_in_single_and_half_precision(
    resources, tmp_path, monkeypatch
):
    question = {"vis": "row:3", "tac": "row:3"}
    for dtype in ("float32", "float16"):
        file = tmp_path / f"{dtype}.safetensors"
        save_embeddings(file, resources.embeddings(), dtype=dtype)
        found = []
        for limit in (0, 10**9):
            monkeypatch.setattr("app.shared.resources.MAPPED_BYTES", limit)
            beside = Resources(replace(resources.where, embeddings=file), resources.shared)
            assert beside.embeddings().vis.flags.writeable == (limit > 0)
            found.append(predicted(beside, question))
        assert found[0] == found[1]


def test_a_head_is_trained_for_its_learned_order_or_for_the_range_that_was_drawn(resources):
    head = resources.head()
    assert trained_span(head) == [head.model.order, head.model.order]
    drawn = replace(head, provenance={"train": {"order_draw": True}})
    assert trained_span(drawn) == [-0.1, 1.1]


def test_an_example_of_the_set_needs_no_encoder(resources, monkeypatch):
    monkeypatch.setattr("omnivat.encoders.base.load_encoder", lambda name, **_: 1 / 0)
    assert predicted(resources, {"vis": "example:TAG-sim/wood/0", "tac": "example:TAG-sim/wood/0"})


def test_an_example_outside_the_set_is_encoded_once(resources, encoder):
    for _ in range(2):
        predicted(resources, {"tac": "example:OF Real-sim/steel/new"})
    assert encoder.calls == 1


@pytest.mark.parametrize("entry", [415, 416, 417])  # the second and third of three, and a first
def test_a_spectrum_keeps_its_peaks_when_entries_are_joined(entry):
    magnitudes = np.zeros((3, 600), dtype=np.float32)
    magnitudes[1, entry] = 2.0
    picture = spectrum(magnitudes)
    pixels = np.frombuffer(base64.b64decode(picture["pixels"]), np.uint8)
    pixels = pixels.reshape(picture["rows"], picture["columns"])
    assert (picture["top"], pixels.max(), (pixels > 0).sum()) == (2.0, 255, 1)


def test_many_pairs_are_predicted_as_each_of_them_alone(resources):
    asked = [{"vis": "row:3", "tac": "row:3"}, {"vis": "row:7"}, {"tac": "row:9"}]
    found = many(resources, {"pairs": asked})
    for question, one in zip(asked, found["pairs"], strict=True):
        alone = predicted(resources, question)["exact"]["readings"]
        assert one["readings"].keys() == alone.keys()
        for name, row in alone.items():
            assert one["readings"][name] == pytest.approx(row, abs=2e-6)


def test_other_heads_read_the_pair_as_each_of_them_alone_and_a_broken_one_spoils_none(
    resources, tmp_path
):
    (tmp_path / "broken").mkdir()
    heads = resources.where.head, tmp_path / "broken"
    own = heads[0].parent.name
    beside = Resources(replace(resources.where, compare=heads), resources.shared)
    asked = {"vis": "row:3", "tac": "row:3"}
    found = rivals(beside, asked)
    alone = predicted(beside, {**asked, "head": own})
    assert set(found) == {own, "broken"}
    assert found[own]["exact"]["order"] == alone["learned"]
    for name, row in alone["exact"]["readings"].items():
        assert found[own]["exact"]["readings"][name] == pytest.approx(row, abs=2e-6)
    assert "settings.json" in found["broken"]["problem"] and "/" not in found["broken"]["problem"]
    with pytest.raises(ForgottenError):
        rivals(beside, {"vis": "image:lost"})
