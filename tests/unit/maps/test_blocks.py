"""Large sets: walked in blocks, with the same results and no copy of the whole."""

from importlib import import_module

import numpy as np
import pytest

from omnivat.data import arrays
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.head.head import build_head
from omnivat.head.predict_set import predicted_probabilities
from omnivat.maps.sweep import STAGES, curve_values, facts_of, sweep, walk
from omnivat.study.protocol.records import fingerprint
from tests.builders import head_settings


@pytest.fixture
def mapped(make_embeddings, tmp_path, monkeypatch):
    """A set that is mapped to be read only, as a large one is."""
    monkeypatch.setattr(arrays, "LARGE_BYTES", 0)
    monkeypatch.setattr(arrays, "WALKED_BYTES", 100)
    save_embeddings(tmp_path / "set.safetensors", make_embeddings())
    return load_embeddings(tmp_path / "set.safetensors")


@pytest.fixture
def model(mapped):
    return build_head(head_settings(mapped, width=16))


def test_a_sweep_that_keeps_no_coefficients_and_no_features_has_the_same_curves(
    mapped, model, monkeypatch
):
    orders = (0.0, 0.4, 1.0)
    _, facts = facts_of(mapped, mapped.header.classes)
    measures = ("modality_gap", "domain_gap", "margin", "accuracy")
    wanted = {
        (name, found.order): value
        for found in walk(model, mapped, orders, stages=STAGES)
        for _, name, value in curve_values(found, facts, measures)
    }
    monkeypatch.setattr(import_module("omnivat.maps.sweep.walk"), "KEPT_PAIRS", 0)
    monkeypatch.setattr(import_module("omnivat.maps.sweep.walk"), "CHUNK", 5)
    got = sweep(model, mapped, orders, stages=STAGES, measures=measures)
    for (name, order), value in wanted.items():
        assert got.curves[name][orders.index(order)] == pytest.approx(value, abs=1e-5, nan_ok=True)
    summed = list(walk(model, mapped, orders, stages=STAGES, sums_for=facts))
    assert all(not found.features and found.sums for found in summed)


def test_a_large_set_in_half_precision_is_widened_block_by_block_with_the_same_results(
    mapped, model, tmp_path, monkeypatch
):
    save_embeddings(tmp_path / "half.safetensors", mapped, dtype="float16")
    large = load_embeddings(tmp_path / "half.safetensors")
    assert large.vis.dtype == np.float16
    assert not large.vis.flags.writeable
    monkeypatch.setattr(arrays, "LARGE_BYTES", 10**9)
    small = load_embeddings(tmp_path / "half.safetensors")
    assert small.vis.dtype == large.select(np.arange(4)).vis.dtype == np.float32
    assert arrays.copied(large.tac).dtype == np.float32
    assert np.array_equal(arrays.copied(large.tac), small.tac)
    assert {block.dtype for block in arrays.walked(large.tac)} == {np.dtype(np.float32)}
    assert fingerprint(large) == fingerprint(small)
    scores = (predicted_probabilities(model, found)["fused"] for found in (large, small))
    assert np.array_equal(*(score.numpy() for score in scores))
